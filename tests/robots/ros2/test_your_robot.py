"""The way over ROS 2 of docs/your-robot.md, followed as a reader would: the mapping is proposed, set, and driven by."""

from __future__ import annotations

import asyncio
import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.base.child_processes import python
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import Robot, Ros2Driver, domain, mapping, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.blocking(reason="follows the page; nothing else is on the loop"),
]

ROOT = paths.config_dir().parent
COMMANDS = (ROOT / "docs" / "your-robot.md").read_text("utf-8").splitlines()
#: What a reader sets in the mapping.
SET = {"model: robot.urdf": "model: my_robot.urdf", "watchdog_s: null": "watchdog_s: 0.5"}


def command(begin: str) -> list[str]:
    """The one command of the page that begins so, as its words."""
    (line,) = [line for line in COMMANDS if line.startswith(begin)]
    return shlex.split(line)


async def test_a_robot_over_ros_2_is_mapped_and_driven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    around = {"ROS_DOMAIN_ID": str(domain()), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONPATH": str(ROOT)}
    model = paths.config_dir() / "robots" / "turtlebot4.urdf"
    (tmp_path / "my_robot.urdf").write_text(model.read_text("utf-8"), "utf-8")
    robot = Robot(tmp_path)
    try:
        *words, _, name = command("hbba ros map")
        done = await asyncio.to_thread(
            subprocess.run, python("-m", "app.cli", *words[1:]), capture_output=True, text=True,
            env=os.environ | around, timeout=PATIENCE_S, check=True,
        )  # fmt: skip
        text = re.sub(r"^program: .*\n", "", done.stdout, flags=re.MULTILINE)
        for proposed, mine in SET.items():
            assert proposed in text
            text = text.replace(proposed, mine)
        (tmp_path / name).write_text(text, "utf-8")
        assert cli.main(command("hbba check my_robot.yaml")[1:]) == 0, f"{capsys.readouterr()}, of\n{text}"
        async with Ros2Driver(mapping(tmp_path / name)) as driver:
            await driver.set_out()
    finally:
        robot.close()
