"""``hbba experiment``: mistakes are one sentence, and scenarios are named as for ``hbba run``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app import cli
from app.experiments.barn.experiment import plan
from app.experiments.barn.result import WorldResult
from app.experiments.results_store import ResultsStore
from app.tours.tour_file import tour_text
from tests.tours.tours import tour


@pytest.mark.parametrize("which", ["trial", "overload"])
@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        ("none", "--scenario: an experiment needs a scenario that drives"),
        (
            "trail",
            "--scenario: there is no scenario trail; did you mean 'trial'? Allowed: a file, none",
        ),
    ],
)
def test_a_scenario_that_does_not_drive_is_refused(
    which: str, scenario: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["experiment", which, "--scenario", scenario]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("command", [["experiment", "trial", "--virtual"], ["replay", "morning", "--headless"]])
@pytest.mark.parametrize("name", ["../x", ".hidden", "a/b", "x" * 101])
def test_a_recordings_name_is_checked_before_anything_begins(
    command: list[str], name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main([*command, "--record", name])
    assert left.value.code == 2
    rule = "a recording's name has 1 to 100 letters, digits, '.', '_' or '-' and begins with a letter or a digit"
    assert f"argument --record: {rule}, not {name!r}\n" in capsys.readouterr().err


def barn_files(folder: Path) -> tuple[Path, Path]:
    """A file of one world, and a folder with its result as another run has kept it."""
    worlds = folder / "worlds.json"
    world = {"id": 4, "cylinders": [], "start": [0, 0, 0], "goal": [3, 0], "path_length": 3.0}
    worlds.write_text(json.dumps({"worlds": [world]}))
    kept = ResultsStore(folder / "out", plan(worlds).of())
    kept.add(WorldResult("4", "success", 4.0, 1.5, 1.0, "", 0, 2.0, 0.1, (), ((0, 0, 0, 0), (4, 2, 0, 0))).document())
    return worlds, folder / "out"


def test_barn_reports_its_results_and_draws_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    worlds, out = barn_files(tmp_path)
    arguments = ["experiment", "barn", "--worlds", str(worlds), "--out", str(out)]
    assert cli.main([*arguments, "--plot", "4"]) == 0
    said = capsys.readouterr()
    assert "1 of 1 worlds are done already" in said.err
    assert "| successes, % | 100.0 |" in said.out
    assert (out / "world_4.png").is_file()
    assert cli.main([*arguments, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["worlds"][0]["world"] == "4"
    assert result["summary"]["score"] == 0.375


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--only", "5"], "has no world '5'; there are 4"),
        (["--plot", "5"], "--plot: world '5' is not among those to run"),
        (
            ["--config", "none.yaml"],
            "--config: there is no program none.yaml; a file, or one of: jackal, lab, serial_base, ",
        ),
        (["--controller", "dwb"], "--controller: there is no controller 'dwb'; did you mean 'dwa'? allowed: dwa, dwa_"),
        (["--jobs", "0"], "a whole number from 1 to 256"),
        (["--seed", "-1"], "whole number"),
    ],
)
def test_barns_mistakes_are_one_sentence(
    tmp_path: Path, more: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    worlds, out = barn_files(tmp_path)
    try:
        status = cli.main(["experiment", "barn", "--worlds", str(worlds), "--out", str(out), *more])
    except SystemExit as refusal:
        status = int(refusal.code or 0)
    assert status == 2
    assert words in capsys.readouterr().err


def test_a_tour_whose_places_the_world_lacks_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "arm-tour.yaml"
    file.write_text(tour_text(tour(id="arm-tour", home="nowhere")), encoding="utf-8")
    assert cli.main(["experiment", "tour", "--tour", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "the tour arm-tour has no place nowhere; before the posters of the world" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
