"""A robot behind rosbridge's WebSocket in another process, for tests, and its mapping."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from app.base.child_processes import python
from app.robots.ros2.config import Ros2Config, load_ros2_config
from tests.patience import PATIENCE_S
from tests.robots.played import PlayedRobot
from tests.robots.ros2.robot import MAPPING
from tests.robots.simulated.kinematic.rooms import kept


class RosbridgeRobot(PlayedRobot):
    """A robot, in a room; ``url`` is where its rosbridge listens."""

    def __init__(self, folder: Path, *options: str, file: Path = MAPPING) -> None:
        log = folder / "robot.log"
        command = python(
            *("-m", "app.robots.simulated.rosbridge_player", "--robot", str(file), "--map", str(kept(folder))),
            *("--log", str(log), "--port", "0", *options),
        )
        super().__init__(command, log, os.environ)
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()


def mapping(url: str, file: Path = MAPPING, **graph: Any) -> Ros2Config:
    """The mapping of ``file``, by default as shipped, of the robot at ``url``."""
    config = load_ros2_config(file)
    wanted = {"rosbridge": url, "found_within_s": PATIENCE_S} | graph
    return config.model_copy(update={"graph": config.graph.model_copy(update=wanted)})
