"""``hbba calibrate``: measured, written where strategies find it, and refused in words."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from app import cli
from app.attention.calibration import load_cost_calibration
from app.base import paths
from app.commands.calibrate import _newest
from app.logs import open as opening
from app.logs.manifest import Manifest
from tests.logs.replay.logs import MemoryLog, lab_log, numbered, write_log

pytestmark = [pytest.mark.slow, pytest.mark.blocking(reason="the virtual loop waits for threads by design")]


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A copy of the lab's program, to be calibrated."""
    return Path(shutil.copytree(paths.config_dir(), tmp_path / "config")) / "lab.yaml"


@pytest.fixture
def log_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that opens as a log of six seconds."""
    monkeypatch.setattr(opening, "open_log", lambda path, remap=None: lab_log(6.0))
    file = tmp_path / "minute.mcap"
    file.write_bytes(b"opened by the fixture")
    return file


def test_strategies_cost_what_was_measured(program: Path, log_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["calibrate", str(log_file), "--config", str(program), "--only", "CameraStream,Teleop"]) == 0
    said = capsys.readouterr()
    assert "CameraStream.images" in said.out
    assert "4 runs of 6 s" in said.err
    assert "CameraStream.images\n" in said.out
    assert "strategy        declared  measured" in said.out
    assert "kinect was recorded at 10.0 Hz of 15; what is measured on it holds for that" in said.err
    calibration = load_cost_calibration(program.parent / "calibration", paths.host_name())
    assert calibration is not None
    relation = calibration.relations["CameraStream.images"]
    assert [point.phi for point in relation.points] == [1, 2, 4, 8]
    assert relation.points[0].events == pytest.approx(10, rel=0.05)
    assert relation.points[3].events == pytest.approx(10 / 8, rel=0.2)
    folder = program.parent / "calibration"
    assert {file.suffix for file in folder.iterdir()} == {".yaml", ".png"}
    assert cli.main(["check", str(program), str(folder / f"{paths.host_name()}.yaml")]) == 0
    capsys.readouterr()
    # What is not measured now stays as it was.
    once_more = ["calibrate", str(log_file), "--config", str(program), "--only", "PointCloudBuilder", "--seconds", "5"]
    assert cli.main(once_more) == 0
    assert "CameraStream.images (measured before, kept)" in capsys.readouterr().out
    assert cli.main([*once_more, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["measured"] == ["PointCloudBuilder.images"]
    assert result["written"][0] == str(folder / f"{paths.host_name()}.yaml")
    assert set(result["calibration"]["relations"]) == {"CameraStream.images", "PointCloudBuilder.images"}
    assert all(row["measured"] > 0 for row in result["strategies"])
    both = load_cost_calibration(folder, paths.host_name())
    assert both is not None
    assert both.relations["CameraStream.images"] == relation
    assert "PointCloudBuilder.images" in both.relations


def test_each_mistake_is_one_sentence(
    program: Path, log_file: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def said(*arguments: str) -> str:
        assert cli.main(["calibrate", *arguments, "--config", str(program)]) == 2
        return capsys.readouterr().err

    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path / "none"))
    assert "record a minute" in said()
    assert "there is no file nothing.mcap" in said("nothing.mcap")
    assert "there is no module 'Eye'" in said(str(log_file), "--only", "Eye")
    assert "has 2.0 s to measure on after --from 4; 5 s are the least" in said(str(log_file), "--from", "4")
    assert "--seconds 2: less than 5 s says little" in said(str(log_file), "--seconds", "2")
    assert "no input 'CameraStream.picture' is fed" in said(str(log_file), "--phi", "CameraStream.picture=2-3")
    whole = "--phi: odometry, the channel of QRCodeDetector.odometry, may not be decimated: only"
    assert whole in said(str(log_file), "--phi", "QRCodeDetector.odometry=1-3")
    assert "cannot be written" in said(str(log_file), "--out", "/proc/nowhere/here.yaml")
    (tmp_path / "here.png").mkdir()
    assert "here.png: cannot be written" in said(str(log_file), "--out", str(tmp_path / "here.yaml"))
    monkeypatch.setattr(opening, "open_log", lambda path, remap=None: MemoryLog(numbered(100)))
    assert "no strategy filters an input that this recording could feed; it has odometry" in said(str(log_file))


def test_a_disk_that_fails_meanwhile_is_one_sentence(
    program: Path, log_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # What is measured is written here after each run.
    (tmp_path / ".here.partial.json.new").mkdir()
    options = ["--config", str(program), "--only", "CameraStream", "--out", str(tmp_path / "here.yaml")]
    assert cli.main(["calibrate", str(log_file), *options]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_without_a_log_it_is_the_newest_that_is_finished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path))
    messages = numbered(10)
    later = [replace(logged, at=logged.at + 3600.0) for logged in messages]
    write_log(tmp_path / "later.mcap", later, Manifest())
    write_log(tmp_path / "earlier.mcap", messages, Manifest())
    killed = write_log(
        tmp_path / "killed.mcap", [replace(logged, at=logged.at + 7200.0) for logged in messages], Manifest()
    )
    killed.write_bytes(killed.read_bytes()[:-50])
    assert _newest() == tmp_path / "later.mcap"
