"""Where the token comes from."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.console.access.token import VARIABLE, given_token, new_token


def test_a_file_wins_over_the_environment_which_other_processes_can_read(tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text("of the file, with spaces\n")
    environment = {VARIABLE: "of the environment", "HOME": "/"}
    assert given_token(file, environment) == "of the file, with spaces"
    assert environment == {"HOME": "/"}
    environment[VARIABLE] = "of the environment\n"
    assert given_token(None, environment) == "of the environment"
    assert given_token(None, environment) is None


@pytest.mark.parametrize("content", [b"short", b"", b"two lines\nof it", b"x" * 5000, b"\xff" * 10])
def test_what_is_no_token_is_refused_naming_the_file(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=f"--token-file {file}"):
        given_token(file, {})


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="nowhere: cannot be read: No such file"):
        given_token(tmp_path / "nowhere", {})
    with pytest.raises(ConfigError, match="cannot be read"):
        given_token(tmp_path, {})


def test_a_variable_that_is_no_token_is_named_without_what_it_holds() -> None:
    with pytest.raises(ConfigError, match=VARIABLE) as refused:
        given_token(None, {VARIABLE: "secret"})
    assert "secret" not in str(refused.value)


def test_a_token_made_up_is_random() -> None:
    assert len(new_token()) >= 20
    assert new_token() != new_token()
