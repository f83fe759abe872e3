"""``hbba log rerun``, with the real Rerun where it is installed."""

from __future__ import annotations

import sysconfig
from pathlib import Path

import pytest

from app import cli
from app.base.errors import ConfigError
from app.commands.log_rerun import rerun_program
from app.logs.mcap.file_sink import FileSink
from tests.logs.mcap.disks import BEGIN, MANIFEST, encoder, image, odometry


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    path = tmp_path / "walk.mcap"
    sink = FileSink([path], encoder(), MANIFEST, BEGIN)
    for i in range(10):
        sink.write(BEGIN + i / 10, "odometry", odometry(BEGIN + i / 10))
        sink.write(BEGIN + i / 10, "kinect", image(BEGIN + i / 10))
    sink.close(discard=False)
    return path


def test_another_kind_of_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "walk.bag"
    log.touch()
    assert cli.main(["log", "rerun", str(log)]) == 2
    assert "Rerun reads MCAP files, and walk.bag is none" in capsys.readouterr().err


def test_without_rerun_the_remedy_is_said(
    walk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sysconfig, "get_path", lambda _: str(walk.parent))
    monkeypatch.setenv("PATH", str(walk.parent))
    assert cli.main(["log", "rerun", str(walk)]) == 2
    assert "pip install 'hbba[rerun]'" in capsys.readouterr().err


def test_nothing_is_replaced_unasked(
    walk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program = walk.with_name("rerun")
    program.touch(mode=0o755)
    monkeypatch.setattr(sysconfig, "get_path", lambda _: str(walk.parent))
    out = walk.with_suffix(".rrd")
    out.write_bytes(b"kept")
    assert cli.main(["log", "rerun", str(walk), "-o", str(out)]) == 2
    assert "--force replaces it" in capsys.readouterr().err
    assert out.read_bytes() == b"kept"
    assert cli.main(["log", "rerun", str(walk), "-o", str(walk.with_suffix(".txt"))]) == 2
    assert "Rerun's files are called .rrd" in capsys.readouterr().err


def test_rerun_itself_converts_a_recording(walk: Path) -> None:
    try:
        rerun_program()
    except ConfigError:
        pytest.skip("Rerun is not installed: pip install 'hbba[rerun]'")
    out = walk.with_suffix(".rrd")
    assert cli.main(["log", "rerun", str(walk), "-o", str(out)]) == 0
    assert out.stat().st_size > 10_000
