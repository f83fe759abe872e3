"""The whole way of motion on a robot over ROS 2: a hand, Teleop, the arbiter with its collision monitor, the link, the
guard, the robot; and the robot's own wall ahead."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.base import paths
from app.messages import LinkStatus, Odometry, TeleopCommand
from app.program.config import load_configuration
from app.program.system import System
from app.robots.ros2.link import Ros2Link
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import MAPPING, Robot, mapping, needs_ros2

pytestmark = [pytest.mark.slow, needs_ros2]

PROGRAM = f"""\
robot: {MAPPING}
channels: {paths.config_dir() / "channels.yaml"}
strategies: [strategies.yaml]
attention: {{safe_strategies: [drive-by-hand]}}
modules:
  Hokuyo: {{class: "app.modules.sensors.hokuyo:Hokuyo", outputs: {{scans: scan}}}}
  WheelOdometry:
    class: app.modules.sensors.wheel_odometry:WheelOdometry
    outputs: {{odometry: odometry, joints: joints}}
  Teleop:
    class: app.modules.behaviors.teleop:Teleop
    inputs: {{operator: teleop_command}}
    outputs: {{twist: teleop_twist}}
  MobileBaseControl:
    class: app.modules.actuation.mobile_base_control:MobileBaseControl
    inputs: {{teleop: teleop_twist, scans: scan, odometry: odometry, operator: teleop_command}}
    outputs: {{exploitation: exploitation, status: link_status}}
    settings: {{behaviors: [{{input: teleop, behavior: Teleop, priority: 3}}]}}
  ScenarioCoordinator:
    class: app.modules.motivations.scenario_coordinator:ScenarioCoordinator
    settings: {{desires: [{{class: Teleoperation, security: true}}]}}
"""
STRATEGIES = """\
resources: {cpu: {capacity: 100, unit: "% of one core", description: Computing time}}
strategies:
  - {name: drive-by-hand, class: Teleoperation, utility: 8, filters: {Teleop.twist: 1}, costs: {cpu: 0}}
"""


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """A robot that looks at the pillar, 2.8 m ahead of it."""
    robot = Robot(tmp_path)
    yield robot
    robot.close()


@pytest.mark.blocking(reason="reads its configuration on the loop, as hbba run does before anybody drives")
async def test_a_hand_drives_it_up_to_the_pillar_and_no_farther(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "program.yaml").write_text(PROGRAM, "utf-8")
    (tmp_path / "strategies.yaml").write_text(STRATEGIES, "utf-8")
    clock = RealClock()
    link = Ros2Link(mapping(), clock.offset)
    system = System(load_configuration(tmp_path / "program.yaml"), link=link, clock=clock)
    way: list[Odometry] = []
    statuses: list[LinkStatus] = []
    system.graph.channels["odometry"].observe(way.append)
    system.graph.channels["link_status"].observe(statuses.append)
    number = 0
    async with asyncio.timeout(PATIENCE_S), system:
        while not (len(way) > 20 and way[-1].X_OB.x > 2.0 and all(seen.linear_mps == 0.0 for seen in way[-20:])):
            system.graph.channels["teleop_command"].publish(TeleopCommand(clock.now(), "ada", number, True, 1.0, 0.0))
            number += 1
            await asyncio.sleep(0.05)
    # The pillar's face is at 2.8 m, the robot's radius 0.174 m.
    assert way[-1].X_OB.x < 2.8 - 0.174
    assert max(seen.linear_mps for seen in way) <= 0.30
    assert {"driving", "idle"} <= {status.guard for status in statuses}
