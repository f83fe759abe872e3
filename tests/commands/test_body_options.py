"""The people in the world are the user's choice: a file, one of the project's scenarios by name, or none."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.commands.body_options import add_body_options, chosen
from app.robots.config import RobotConfig
from tests.robots.devices.files import ramp, sound_file

SCENARIOS = paths.config_dir() / "scenarios"
WEBCAM = str(paths.config_dir() / "robots" / "webcam.yaml")


def scenario(*options: str) -> Path | None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--config", type=Path)
    add_body_options(parser)
    _, body = chosen(parser.parse_args(options))
    assert isinstance(body, RobotConfig)
    return body.scenario


def test_people_are_in_the_lab_by_default(tmp_path: Path) -> None:
    assert scenario() == SCENARIOS / "lab.yaml"
    assert scenario("--scenario", "trial") == SCENARIOS / "trial.yaml"
    assert scenario("--scenario", "none") is None
    mine = tmp_path / "mine.yaml"
    mine.write_text("name: mine\n")
    assert scenario("--scenario", str(mine)) == mine


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ["--scenario", "trail"],
            "there is no scenario trail; did you mean 'trial'? Allowed: a file, none, or ",
        ),
        (["--scenario", "none", "--robot", WEBCAM], "is not in it"),
        (["--robot", WEBCAM, "--camera", "gone.mp4"], "--camera: there is no file or folder gone.mp4"),
        (["--robot", WEBCAM, "--microphones", "gone/talk"], "--microphones: there is no file or folder gone/talk"),
        (["--robot", WEBCAM, "--camera", "-1"], "--camera: a camera's number is from 0, not '-1'"),
        (["--robot", WEBCAM, "--microphones", "-1"], "--microphones: an input's number is from 0, not '-1'"),
    ],
)
def test_a_mistake_is_one_sentence(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", *options]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "name", "content", "words"),
    [
        ("--camera", "a.txt", b"hello", "cannot be read as a video (MP4, AVI, MKV, WebM) or a picture (BMP, JPEG, "),
        ("--camera", "a.png", b"hello", "is no picture that can be read (BMP, JPEG, PNG, TIFF, WebP)"),
        (
            "--camera",
            "cut.mp4",
            b"\0\0\0\x18ftypisom" + bytes(2000),
            "it is damaged, breaks off, or is of another kind",
        ),
        ("--microphones", "a.txt", b"hello", "cannot be read as sound (WAV, FLAC, Ogg, MP3): Format not recognised"),
    ],
)
def test_a_named_file_that_cannot_be_read_is_refused_though_the_other_sense_works(
    tmp_path: Path, option: str, name: str, content: bytes, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    other = ["--microphones", str(sound_file(tmp_path, ramp(16)))] if option == "--camera" else []
    assert cli.main(["run", "--robot", WEBCAM, option, str(file), *other]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hbba run: {option}: {file} ")
    assert words in said
    assert said.count(str(file)) == said.count("\n") == 1


def test_a_file_that_the_bodys_own_file_names_is_tried_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.txt").write_text("hello")
    robot = tmp_path / "robot.yaml"
    robot.write_text(
        f"kind: devices\nmodel: {paths.config_dir() / 'robots' / 'desk.urdf'}\ncamera: {{source: a.txt}}\n"
    )
    program = str(paths.config_dir() / "webcam.yaml")
    assert cli.main(["run", "--config", program, "--robot", str(robot)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hbba run: {robot}: camera.source: {tmp_path / 'a.txt'} cannot be read as a video")
