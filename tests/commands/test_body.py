"""``hbba body``: what it writes and says."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.base.kinematic_model import load_model
from app.commands.body_page import slider_ends
from tests.patience import PATIENCE_S
from tests.robots.importing.models import write_mjcf, write_urdf


def test_it_says_what_it_made_and_what_to_do_next(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "arm"
    assert cli.main(["body", "import", str(write_urdf(tmp_path)), "-o", str(out), "--name", "Arm 1"]) == 0
    printed = capsys.readouterr()
    assert f"{out / 'body.yaml'}: 6 links, 3 joints, 0.25 m high" in printed.out
    assert "groups of joints: arm (2)" in printed.out
    assert f"hbba run --config jackal --robot {out / 'body.yaml'}" in printed.out
    assert "lost.stl: was not found" in printed.err
    assert cli.main(["check", str(out / "body.yaml")]) == 0


def test_programs_read_it_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["body", "import", str(write_mjcf(tmp_path)), "-o", str(tmp_path / "arm"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["groups"] == {"yaw": ["yaw", "pitch", "reach"]}
    assert document["file"] == str(tmp_path / "arm" / "body.yaml")


def test_a_mistake_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["body", "import", str(tmp_path / "none.urdf")]) == 2
    assert "none.urdf: cannot be read" in capsys.readouterr().err


def test_a_slider_goes_as_far_as_its_joint(tmp_path: Path) -> None:
    joints = load_model(write_urdf(tmp_path)).joints
    assert slider_ends(joints["arm_1_joint"]) == (-1.0, 2.0)
    assert slider_ends(joints["left_wheel_joint"]) == pytest.approx((-3.14159, 3.14159), abs=1e-3)


def test_a_model_is_shown_until_a_signal(tmp_path: Path) -> None:
    robot = paths.config_dir() / "robots" / "jackal.yaml"
    process = subprocess.Popen(
        [sys.executable, "-m", "app.cli", "body", "show", str(robot), "--port", "0"],
        stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONASYNCIODEBUG": ""}, cwd=Path(__file__).parents[2],
    )  # fmt: skip
    try:
        assert process.stdout is not None
        url = re.search(r"http://\S+", process.stdout.readline())
        assert url is not None
        with urllib.request.urlopen(url[0], timeout=PATIENCE_S) as answer:
            assert b"<html" in answer.read(10_000).lower()
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE_S) == 0
    finally:
        process.kill()
        process.communicate()
