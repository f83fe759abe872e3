"""What ``--json`` prints, whatever the terminal."""

from __future__ import annotations

import io
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.commands.output import check_writable, json_text, print_json, write_text
from tests.patience import PATIENCE_S


def test_what_is_no_number_is_null_and_a_path_is_text() -> None:
    document = {"phi": math.inf, "sigma": [math.nan, 1.5], 2: (Path("a") / "b", None, True, 3)}
    assert json.loads(json_text(document)) == {"phi": None, "sigma": [None, 1.5], "2": ["a/b", None, True, 3]}


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_every_standard_output_can_show_it(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    print_json({"reason": "φ = ∞"})
    sys.stdout.flush()
    assert json.loads(raw.getvalue().decode(encoding)) == {"reason": "φ = ∞"}
    assert ("φ" in raw.getvalue().decode("utf-8")) == (encoding == "utf-8")


def test_an_answer_with_greek_letters_goes_to_a_terminal_without_them(tmp_path: Path) -> None:
    problem = tmp_path / "problem.yaml"
    text = "desires: [{class: GoTo, intensity: 1}]\nstrategies: [{name: φ, class: GoTo, utility: 8}]\n"
    problem.write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "app.cli", "solve", str(problem), "--json"],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True, timeout=PATIENCE_S, check=True,
    )  # fmt: skip
    assert json.loads(done.stdout)["strategies"][0]["name"] == "φ"


def test_a_file_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    check_writable(None)
    check_writable(tmp_path / "new.json")
    with pytest.raises(ConfigError, match="there is no such folder"):
        check_writable(tmp_path / "none" / "new.json")
    with pytest.raises(ConfigError, match="cannot be written"):
        write_text(tmp_path, "{}")
    write_text(tmp_path / "new.json", "{}")
    assert (tmp_path / "new.json").read_text() == "{}"
