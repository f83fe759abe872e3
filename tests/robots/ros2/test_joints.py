"""The head and a gripper of a robot over real ROS 2: they move by their controllers' topics, within the guard."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.logs.ros.live.classes import message_class
from app.messages import GroupStatus, JointCommand, LinkStatus
from app.robots.ros2.config import load_ros2_config
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import WITH_HEAD, Robot, Ros2Driver, domain, mapping, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.blocking(reason="reads a mapping; nothing else is on the loop"),
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # of the parser that rclpy imports
]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "robot_with_head.yaml"
    path.write_text(WITH_HEAD, "utf-8")
    return path


@pytest.fixture
def robot(tmp_path: Path, file: Path) -> Iterator[Robot]:
    robot = Robot(tmp_path, file=file)
    yield robot
    robot.close()


class Joints:
    """The joints of ``driver``, commanded again and again."""

    def __init__(self, driver: Ros2Driver) -> None:
        self._driver = driver

    def at(self, name: str) -> float:
        """The position (rad, m) of a joint, as the robot measures it."""
        joints = self._driver.newest["joints"]
        return float(joints.positions[joints.names.index(name)])

    def status(self, group: str) -> GroupStatus:
        status: LinkStatus = self._driver.newest["status"]
        (found,) = [each for each in status.groups if each.group == group]
        return found

    async def send(self, group: str, name: str, position: float, least: float = -math.inf) -> None:
        """Command the joint ``name`` to ``position`` until it is there, or above ``least`` no more."""
        try:
            async with asyncio.timeout(PATIENCE_S):
                while abs(self.at(name) - position) > 0.01 and self.at(name) > least:
                    self._driver.link.command(JointCommand(self._driver.clock.now(), group, (name,), (position,)))
                    await asyncio.sleep(0.05)
        except TimeoutError:
            raise AssertionError(f"{name} is at {self.at(name)}, not {position}: {self.status(group)}") from None


async def test_head_and_gripper_follow_commands_and_stop_with_them(robot: Robot, file: Path) -> None:
    async with Ros2Driver(mapping(file)) as driver:
        joints = Joints(driver)
        await driver.wait_for("joints and their groups", lambda seen: {"joints", "status"} <= set(seen))
        assert set(driver.link.description.groups) == {"head", "left_gripper"}
        await joints.send("head", "pan_joint", 0.6)
        await joints.send("left_gripper", "left_gripper_joint", 0.03)
        assert joints.at("pan_joint") == pytest.approx(0.6, abs=0.01), "the other group did not move it"
        # An emergency stop holds what is where it is, and a release alone moves nothing.
        await joints.send("head", "pan_joint", -1.0, least=0.2)
        driver.link.e_stop("a test")
        await driver.wait_for("a stop", lambda seen: joints.status("head").reason == "emergency stop: a test")
        await driver.wait_for("a brake", lambda seen: joints.status("head").guard == "holding")
        stood = await still(driver, joints)
        driver.link.clear_e_stop()
        await driver.wait_for("a release", lambda seen: "emergency" not in joints.status("head").reason)
        assert await still(driver, joints) == pytest.approx(stood, abs=1e-3)
        await joints.send("head", "pan_joint", -0.5)


async def test_a_controller_goes_all_the_way_to_its_newest_set_point(robot: Robot, file: Path) -> None:
    """The robot's own: a computer that is late gives it no other, for what stays is not sent again."""
    import rclpy

    from app.robots.ros2.joint_messages import encoded

    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], context=context, domain_id=domain())
    node = rclpy.create_node("teacher", context=context, enable_rosout=False, start_parameter_services=False)
    try:
        async with Ros2Driver(mapping(file)) as driver:
            joints = Joints(driver)
            await driver.wait_for("joints", lambda seen: "joints" in seen)
            topic = load_ros2_config(file).joint_commands["head"]
            publisher = node.create_publisher(message_class(topic.type), "/head_controller/joint_trajectory", 1)
            await driver.wait_for("a controller", lambda seen: publisher.get_subscription_count() > 0)
            publisher.publish(encoded(topic, ("pan_joint",), (0.8,)))
            await driver.wait_for("the end", lambda seen: joints.at("pan_joint") == pytest.approx(0.8, abs=1e-3))
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


async def still(driver: Ros2Driver, joints: Joints, name: str = "pan_joint") -> float:
    """Where the joint ``name`` is once it has been at one place for a while."""
    while True:
        before = joints.at(name)
        for _ in range(10):
            driver.newest.pop("joints")
            await driver.wait_for("joints", lambda seen: "joints" in seen)
        if abs(joints.at(name) - before) < 1e-4:
            return before
