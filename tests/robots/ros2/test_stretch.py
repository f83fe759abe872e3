"""A Stretch by its shipped mapping, over real ROS 2: it is driven, turns its head by the action of its driver, served
by rclpy's own server, and is stopped."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.base import paths
from app.messages import GroupStatus
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import Robot, Ros2Driver, mapping, needs_ros2
from tests.robots.ros2.test_joints import Joints, still

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.blocking(reason="reads what the robot noted; nothing else is on the loop"),
]
MAPPING = paths.config_dir() / "robots" / "stretch.yaml"
ACTION = "/stretch_controller/follow_joint_trajectory"


class Stretch(Robot):
    """A Stretch in a room."""

    def __init__(self, folder: Path) -> None:
        self._goals = folder / "goals.log"
        super().__init__(folder, "--goals", str(self._goals), file=MAPPING)

    def goals(self) -> list[tuple[float, str]]:
        """What became of goals, and when."""
        lines = self._goals.read_text("utf-8").splitlines()
        return [(float(at), what) for at, what in (line.split() for line in lines)]

    async def wait_for_goal(self, what: str, after: int) -> None:
        """Wait until something became of a goal, beyond the first ``after`` notes."""
        deadline = time.monotonic() + PATIENCE_S
        while what not in [noted for _, noted in self.goals()[after:]]:
            assert time.monotonic() < deadline, f"no goal was {what}: {self.goals()[after:]}"
            await asyncio.sleep(0.05)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stretch]:
    robot = Stretch(tmp_path_factory.mktemp("stretch"))
    yield robot
    robot.close()


async def test_it_drives_and_turns_its_head_and_is_stopped(robot: Stretch) -> None:
    robot.fault("goals keep")
    before = len(robot.goals())
    async with Ros2Driver(mapping(MAPPING)) as driver:
        joints = Joints(driver)
        await driver.set_out()
        await driver.wait_for("joints and their groups", lambda seen: {"joints", "status"} <= set(seen))
        await driver.wait_for("the laser and the inertial sensor", lambda seen: {"hokuyo", "imu"} <= set(seen))
        imu = driver.newest["imu"]
        assert imu.frame == "imu_mobile_base"
        assert imu.specific_force[2] == pytest.approx(9.81)
        assert imu.angular_velocity == pytest.approx((0.0, 0.0, 0.3), abs=0.31)
        # The head follows while the base drives: each goal replaces the one before, and none comes too soon.
        await joints.send("head", "joint_head_pan", -0.8)
        await joints.send("head", "joint_head_tilt", -0.4)
        noted = [what for _, what in robot.goals()[before:]]
        assert {"accepted", "replaced"} <= set(noted)
        assert "rejected" not in noted
        # An emergency stop stops both: the goal is cancelled, and the head stays where it is.
        before = len(robot.goals())
        await joints.send("head", "joint_head_pan", -2.5, least=-1.3)
        driver.link.e_stop("a test")
        await driver.stopped_for("emergency stop: a test")
        await robot.wait_for_goal("cancelled", before)
        assert await still(driver, joints, "joint_head_pan") > -2.0
        assert joints.status("head").reason == "emergency stop: a test"
        stopped = len(robot.goals())
        driver.link.clear_e_stop()
        await driver.wait_for("a release", lambda seen: "emergency" not in joints.status("head").reason)
        assert len(robot.goals()) == stopped, "nothing goes on by itself"
        # Nothing is commanded any more: the last goal is cancelled, too.
        async with commanded(joints):
            await robot.wait_for_goal("accepted", stopped)
        await robot.wait_for_goal("cancelled", stopped)
        await driver.wait_for("no command", lambda seen: joints.status("head").reason.startswith("no fresh command"))


async def test_what_becomes_of_a_goal_is_said_in_words(robot: Stretch) -> None:
    async with Ros2Driver(mapping(MAPPING)) as driver:
        joints = Joints(driver)
        await driver.wait_for("joints and their groups", lambda seen: {"joints", "status"} <= set(seen))
        for fault, said in (
            ("goals reject", f"{ACTION} rejected the goal"),
            ("goals abort", f"{ACTION}: the goal was aborted: its joints are not the robot's: aborted"),
            ("goals off", f"nothing serves the action {ACTION}: commands do not reach the robot"),
        ):
            robot.fault(fault)
            async with commanded(joints):
                status = await reason(driver, joints, said)
            assert status.guard == ("holding" if fault == "goals off" else "refused")
        # It serves again: the head moves without any other word.
        robot.fault("goals on")
        robot.fault("goals take")
        await joints.send("head", "joint_head_pan", -0.3)


async def reason(driver: Ros2Driver, joints: Joints, said: str) -> GroupStatus:
    """The first status of the head with this reason."""
    found: list[GroupStatus] = []

    def is_said(seen: object) -> bool:
        status = joints.status("head")
        if status.reason == said:
            found.append(status)
        return bool(found)

    await driver.wait_for(said, is_said)
    return found[0]


class commanded:  # reads as what it does
    """While in it, the head is commanded again and again."""

    def __init__(self, joints: Joints) -> None:
        self._joints = joints

    async def __aenter__(self) -> None:
        self._task = asyncio.create_task(self._joints.send("head", "joint_head_pan", -3.0))

    async def __aexit__(self, *_: object) -> None:
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)
