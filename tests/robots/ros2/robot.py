"""A robot in a real ROS 2 process for tests, and a link to it, in a graph that nothing else is in."""

from __future__ import annotations

import asyncio
import importlib.util
import os
import sys
import zlib
from pathlib import Path
from typing import Any

import pytest

from app.base import paths
from app.base.child_processes import python
from app.robots.ros2.config import Ros2Config, load_ros2_config
from app.robots.ros2.link import Ros2Link
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S
from tests.robots.played import Driver, PlayedRobot
from tests.robots.simulated.kinematic.rooms import kept

MAPPING = paths.config_dir() / "robots" / "turtlebot4.yaml"
#: The mapping of a robot with a head and a gripper, whose controllers take topics.
WITH_HEAD = f"""\
kind: ros2
name: A robot with a head
model: {paths.config_dir() / "robots" / "irl1_tr.urdf"}
footprint: [[0.28, -0.28], [0.28, 0.28], [-0.28, 0.28], [-0.28, -0.28]]
limits: {{linear_mps: 0.3, angular_radps: 1.0, linear_mps2: 0.4, angular_radps2: 2.0, required_sensors: [odometry]}}
actuators:
  head: {{joints: [pan_joint, tilt_joint], velocity: 1.05, acceleration: 5.8}}
  left_gripper: {{joints: [left_gripper_joint], velocity: 0.1, acceleration: 1.0}}
streams:
  odometry: {{topic: odom, rate_hz: 100}}
  joints: {{topic: joint_states, rate_hz: 30}}
base: {{topic: cmd_vel, type: geometry_msgs/msg/TwistStamped, watchdog_s: 0.5}}
joint_commands:
  head: {{topic: head_controller/joint_trajectory}}
  left_gripper: {{topic: gripper_controller/commands, type: std_msgs/msg/Float64MultiArray}}
"""
needs_ros2 = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="ROS 2 is not installed: pip install 'hbba[ros2]'"
)


def domain() -> int:
    """A domain of this worker's own, of those whose ports no other program is given."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    return 1 + (zlib.crc32(str(paths.config_dir()).encode()) + 7 * int(worker)) % 100


def mapping(file: Path = MAPPING, **graph: Any) -> Ros2Config:
    """The mapping of ``file``, by default as shipped, in the domain of this worker and on this computer alone."""
    config = load_ros2_config(file)
    wanted = {"domain": domain(), "discovery": "localhost", "found_within_s": PATIENCE_S} | graph
    return config.model_copy(update={"graph": config.graph.model_copy(update=wanted)})


class Robot(PlayedRobot):
    """A robot over ROS 2."""

    def __init__(self, folder: Path, *options: str, file: Path = MAPPING, body: Path | None = None) -> None:
        """The robot of the mapping ``file``, in a room, or as the simulated ``body`` in its world."""
        log = folder / "robot.log"
        where = ("--map", str(kept(folder))) if body is None else ("--body", str(body))
        command = python(
            *("-m", "app.robots.simulated.ros2_player", "--robot", str(file), *where),
            *("--log", str(log), "--domain", str(domain()), *options),
        )
        around = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        super().__init__(command, log, around)


class Ros2Driver(Driver):
    """A driven link to the robot of a mapping; ``ros2`` is the same as ``link``."""

    def __init__(self, config: Ros2Config) -> None:
        clock = RealClock()
        self.ros2 = Ros2Link(config, clock.offset)
        super().__init__(self.ros2, clock)


if __name__ == "__main__":  # a program that drives, to be frozen and killed

    async def main(number: int) -> None:
        """Drive for as long as it is let."""
        async with Ros2Driver(mapping(domain=number)) as driver:
            await driver.set_out()
            print("driving", driver.ros2.process_id, flush=True)
            await asyncio.Event().wait()

    asyncio.run(main(int(sys.argv[1])))
