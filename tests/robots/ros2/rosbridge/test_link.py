"""A robot behind rosbridge's WebSocket, in another process: it is driven, and goes wrong in every way; its base stops,
and the status of the link says why."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from app.link import LinkFailed
from app.messages import Image, JointCommand, JointState, LaserScan, LinkStatus
from tests.patience import PATIENCE_S
from tests.robots.played import odometry
from tests.robots.ros2.robot import MAPPING, WITH_HEAD, Ros2Driver
from tests.robots.ros2.rosbridge.robot import RosbridgeRobot, mapping

pytestmark = [
    pytest.mark.slow,
    pytest.mark.blocking(reason="reads the robot's log and feeds it faults; nothing else is on the loop"),
]


@pytest.fixture
def start_robot(tmp_path: Path) -> Iterator[Callable[..., RosbridgeRobot]]:
    """Start robots that end with the test."""
    robots: list[RosbridgeRobot] = []

    def start(*options: str, file: Path = MAPPING) -> RosbridgeRobot:
        robots.append(RosbridgeRobot(tmp_path, *options, file=file))
        return robots[-1]

    yield start
    for robot in robots:
        robot.close()


async def stands(robot: RosbridgeRobot) -> None:
    """Wait until the robot has stood for a while."""
    steps = 20
    await asyncio.to_thread(
        robot.wait_for, "standing", lambda rows: len(rows) > steps and all(row.still for row in rows[-steps:])
    )


async def test_whatever_goes_wrong_with_the_robot_its_base_stops(
    start_robot: Callable[..., RosbridgeRobot], caplog: pytest.LogCaptureFixture
) -> None:
    # Its own watchdog is slow: what stops it is what is sent.
    robot = start_robot("--pictures", "320", "240", "5", "--watchdog", "600")
    gone = f"odometry (/odom): rosbridge at {robot.url} does not answer"
    driver = Ros2Driver(mapping(robot.url))
    async with driver:
        await driver.set_out()
        await driver.wait_for("every stream", lambda seen: {"hokuyo", "joints", "battery", "camera"} <= seen.keys())
        scan, joints, picture = (driver.newest[name] for name in ("hokuyo", "joints", "camera"))
        assert isinstance(scan, LaserScan)
        assert scan.frame == "rplidar_link"
        assert 0.15 < float(scan.ranges[scan.ranges > 0].min()) < 2.0
        assert isinstance(joints, JointState)
        assert set(joints.names) == {"left_wheel_joint", "right_wheel_joint"}
        assert isinstance(picture, Image)
        assert picture.color.shape == (240, 320, 3)
        assert picture.color[120, 2, 0] > 250 > 5 > picture.color[120, 2, 1]
        driver.link.demand("camera", 0.0)
        # Odometry begins again: what was built on it is void. The last word, whatever ended it, is zero.
        await driver.wait_for("some way", lambda seen: np.hypot(odometry(seen).X_OB.x, odometry(seen).X_OB.y) > 0.6)
        robot.fault("origin")
        async with asyncio.timeout(PATIENCE_S):
            failure = await driver.link.wait_failed()
        assert str(failure) == "The robot's odometry jumped: it began again, and what was built on it is void."
        await stands(robot)
        await driver.link.start()
        # No command any more, then an emergency stop though commands go on
        driver.commands = False
        await driver.stopped_for("no fresh command")
        await stands(robot)
        await driver.set_out()
        driver.link.e_stop("a test")
        await driver.stopped_for("emergency stop: a test")
        await stands(robot)
        driver.link.clear_e_stop()
        # Odometry ends, while the robot goes on taking commands
        await driver.set_out()
        robot.fault("odometry off")
        status = await driver.stopped_for("odometry has given nothing", "/odom has a publisher, which is silent")
        assert status.guard == "sensor_failure"
        await stands(robot)
        robot.fault("odometry on")
        # Frames that are no messages of the protocol end nothing
        await driver.set_out()
        for frame in (
            "no JSON",
            "[1, 2]",
            "{}",
            '{"op": "fragment"}',
            '{"op": "publish"}',
            '{"op": "status", "level": "error", "msg": 7}',
        ):
            robot.fault(f"say {frame}")
        robot.fault('say {"op": "publish", "topic": "/odom", "msg": {"header": {"stamp": "noon"}}}')
        await driver.wait_for("a wrong field", lambda _: "builtin_interfaces/Time" in caplog.text)
        assert "sent what cannot be read: it is no JSON" in caplog.text
        assert "sends large messages in fragments" in caplog.text
        await driver.set_out()
        # Its clock is set
        robot.fault("clock 3600")
        await driver.stopped_for("odometry (/odom): its time lies 3600.", "s in the future", "synchronize")
        await stands(robot)
        robot.fault("clock 0")
        # rosbridge ends, while the robot would drive on, and runs again
        await driver.set_out()
        robot.fault("bridge off")
        await driver.stopped_for(gone)
        robot.fault("bridge on")
        await driver.set_out()
        # Its computer freezes, and thaws while there is no command
        os.kill(robot.process.pid, signal.SIGSTOP)
        try:
            await driver.stopped_for(gone)
            driver.commands = False
        finally:
            os.kill(robot.process.pid, signal.SIGCONT)
        await stands(robot)
        # It dies
        await driver.set_out()
        os.kill(robot.process.pid, signal.SIGKILL)
        await driver.stopped_for(f"{gone}: nothing listens there")
    with pytest.raises(LinkFailed) as refused:
        await Ros2Driver(mapping(robot.url, found_within_s=0.5)).link.start()
    assert str(refused.value).startswith(f"TurtleBot 4 was not found within 0.5 s: {gone}")
    assert str(refused.value).endswith(". Topics that are there: none.")


HEAD = WITH_HEAD.replace("TwistStamped", "Twist")


async def test_a_robot_of_ros_1_drives_and_turns_its_head(
    start_robot: Callable[..., RosbridgeRobot], tmp_path: Path
) -> None:
    file = tmp_path / "head.yaml"
    file.write_text(HEAD, "utf-8")
    robot = start_robot("--ros1", file=file)
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(HEAD.replace("geometry_msgs/msg/Twist,", "geometry_msgs/msg/TwistStamped,"), "utf-8")
    line = 1 + next(n for n, text in enumerate(HEAD.splitlines()) if text.startswith("base:"))
    with pytest.raises(LinkFailed) as refused:
        await Ros2Driver(mapping(robot.url, wrong)).link.start()
    assert str(refused.value) == (
        f"{wrong}:{line}: base.type: /cmd_vel has the type geometry_msgs/Twist; "
        "the mapping reads or writes geometry_msgs/msg/TwistStamped"
    )
    async with Ros2Driver(mapping(robot.url, file)) as driver:
        await driver.set_out()
        targets = {
            ("head", ("pan_joint", "tilt_joint"), (0.4, -0.2)),
            ("left_gripper", ("left_gripper_joint",), (0.03,)),
        }

        async def turn() -> None:
            while True:
                for target in targets:
                    driver.link.command(JointCommand(driver.clock.now(), *target))
                await asyncio.sleep(0.05)

        turning = asyncio.create_task(turn())

        def turned(seen: dict[str, object]) -> bool:
            joints = seen.get("joints")
            assert isinstance(joints, JointState)
            at = dict(zip(joints.names, joints.positions, strict=True))
            wanted = {name: goal for _, names, goals in targets for name, goal in zip(names, goals, strict=True)}
            return all(abs(at[name] - goal) < 0.01 for name, goal in wanted.items())

        await driver.wait_for("the head there", turned)
        turning.cancel()
        status = driver.newest["status"]
        assert isinstance(status, LinkStatus)
        assert {group.group for group in status.groups} == {"head", "left_gripper"}
