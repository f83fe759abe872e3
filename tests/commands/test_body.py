"""Who is in the world is the user's choice: a file, one of the project's scenarios by name, or nobody."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from app import cli, paths
from app.commands.body import add_body_options, chosen
from app.robots.config import RobotConfig

SCENARIOS = paths.config_dir() / "scenarios"
WEBCAM = str(paths.config_dir() / "robots" / "webcam.yaml")


def scenario(*options: str) -> Path | None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--config", type=Path)
    add_body_options(parser)
    _, body = chosen(parser.parse_args(options))
    assert isinstance(body, RobotConfig)
    return body.scenario


def test_people_live_in_the_lab_unless_told_otherwise(tmp_path: Path) -> None:
    assert scenario() == SCENARIOS / "lab.yaml"
    assert scenario("--scenario", "trial") == SCENARIOS / "trial.yaml"
    assert scenario("--scenario", "none") is None
    mine = tmp_path / "mine.yaml"
    mine.write_text("name: mine\n")
    assert scenario("--scenario", str(mine)) == mine


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--scenario", "trail"], "there is no scenario trail; a file, none, or one of: lab, mapping, trial, walkers"),
        (["--scenario", "none", "--robot", WEBCAM], "in the real one"),
        (["--robot", WEBCAM, "--camera", "gone.mp4"], "--camera: there is no file or folder gone.mp4"),
        (["--robot", WEBCAM, "--microphones", "gone/talk"], "--microphones: there is no file or folder gone/talk"),
    ],
)
def test_a_mistake_is_one_sentence(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", *options]) == 2
    assert words in capsys.readouterr().err
