"""The file of a fleet: what it may say, and what it is refused for."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.console.fleet.fleet_file import load_fleet


def write(folder: Path, text: str) -> Path:
    file = folder / "fleet.yaml"
    file.write_text(text)
    return file


def test_consoles_come_in_order_with_their_tokens(tmp_path: Path) -> None:
    (tmp_path / "irl2.token").write_text("secret\n")
    consoles = load_fleet(
        write(
            tmp_path,
            "robots:\n- {url: 'http://127.0.0.1:8082/', token_file: irl2.token}\n- {url: 'https://IRL3.lan'}\n",
        )
    )
    assert [(c.url, c.token) for c in consoles] == [("http://127.0.0.1:8082", "secret"), ("https://irl3.lan", None)]
    assert [c.tls is not None for c in consoles] == [False, True]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("robots: []\n", 1, "robots"),
        ("robots:\n- {url: 'ftp://there'}\n", 2, "a URL begins with https:// or http://"),
        ("robots:\n- {url: 'http://there/page'}\n", 2, "scheme, host and port alone"),
        ("robots:\n- {url: 'http://a:1'}\n- {url: 'http://A:1/'}\n", 3, "named twice"),
        ("robots:\n- {url: 'http://a', token_file: absent}\n", 2, "cannot be read: No such file"),
        ("robots:\n- {url: 'http://a', token_file: fleet.yaml}\n", 2, "should hold one line"),
        ("robots:\n- {url: 'http://a', ca: fleet.yaml}\n", 2, "ca is for https"),
        ("robots:\n- {url: 'https://a', ca: fleet.yaml}\n", 2, "no certificate in PEM"),
    ],
)
def test_what_is_wrong_is_refused_with_its_line(tmp_path: Path, text: str, line: int, words: str) -> None:
    file = write(tmp_path, text)
    with pytest.raises(ConfigError) as refused:
        load_fleet(file)
    assert f"{file}:{line}" in str(refused.value)
    assert words in str(refused.value)
