"""``hbba bench``: found in a checkout, refused elsewhere, and a wrong name lists what there is."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from app import cli
from app.base import paths


def test_a_name_that_is_none_lists_those_there_are(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench", "speed"]) == 2
    said = capfd.readouterr().err
    listed = said[said.index("there is no benchmark speed; there are ") :].split("are ")[1].strip().split(", ")
    assert {"channels", "solver"} < set(listed)
    assert listed == sorted(listed)


def test_an_installed_program_says_where_the_benchmarks_are(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(paths, "checkout_dir", lambda: None)
    assert cli.main(["bench"]) == 2
    assert capsys.readouterr().err == (
        "hbba bench: the benchmarks come with the source: run this in a checkout of the project\n"
    )


def test_results_are_written_to_the_current_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran: list[list[str]] = []

    def run(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        ran.append(command)
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("subprocess.run", run)
    assert cli.main(["bench", "solver", "--out", "rows.json", "--quick"]) == 0
    assert ran[0][3:] == ["solver", "--quick", "--out", str(tmp_path / "rows.json")]


def test_rows_are_the_only_thing_on_standard_output_for_programs(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench", "supervision", "--quick", "--json"]) == 0
    out, err = capfd.readouterr()
    result = json.loads(out)
    assert {row["benchmark"] for row in result["rows"]} == {"supervision"}
    assert "== supervision (1 of 1)" in err
