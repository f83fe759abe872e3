"""A robot in another process, over real ROS 2: it is driven, and goes wrong in every way; its base stops, and the
status of the link says why."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from app.base import paths
from app.base.child_processes import python
from app.link import LinkFailed
from app.messages import JointState, LaserScan
from tests.patience import PATIENCE_S
from tests.robots.played import Driver, odometry
from tests.robots.ros2.robot import MAPPING, Robot, Ros2Driver, domain, mapping, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.blocking(reason="reads the robot's log and feeds it faults; nothing else is on the loop"),
]


@pytest.fixture
def start_robot(tmp_path: Path) -> Iterator[Callable[..., Robot]]:
    """Start robots that end with the test."""
    robots: list[Robot] = []

    def start(*options: str) -> Robot:
        robots.append(Robot(tmp_path, *options))
        return robots[-1]

    yield start
    for robot in robots:
        robot.close()


async def stands(robot: Robot) -> None:
    """Wait until the robot has stood for a second: a computer that thaws goes through what waited in its socket."""
    steps = 20
    await asyncio.to_thread(
        robot.wait_for, "standing", lambda rows: len(rows) > steps and all(row.still for row in rows[-steps:])
    )


async def test_whatever_goes_wrong_with_the_robot_its_base_stops(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot()
    async with Ros2Driver(mapping()) as driver:
        await driver.set_out()
        await driver.wait_for("every stream", lambda seen: {"hokuyo", "joints", "battery"} <= seen.keys())
        check_what_came(driver)
        # No command any more
        driver.commands = False
        status = await driver.stopped_for("no fresh command")
        assert status.guard == "stale_command"
        await stands(robot)
        # An emergency stop, though commands go on
        await driver.set_out()
        driver.link.e_stop("a test")
        assert (await driver.stopped_for("emergency stop: a test")).e_stopped
        await stands(robot)
        driver.link.clear_e_stop()
        # Odometry ends, while the robot goes on taking commands
        await driver.set_out()
        robot.fault("odometry off")
        status = await driver.stopped_for("odometry has given nothing", "/odom has a publisher, which is silent")
        assert status.guard == "sensor_failure"
        await stands(robot)
        robot.fault("odometry on")
        # Its clock is set
        await driver.set_out()
        robot.fault("clock 3600")
        await driver.stopped_for("odometry (/odom): its time lies 3600.", "s in the future", "synchronize")
        await stands(robot)
        robot.fault("clock -3600")
        await driver.stopped_for("its time lies 3600.", "s in the past")
        robot.fault("clock 0")
        # Its computer freezes, and thaws when nobody drives any more
        await driver.set_out()
        os.kill(robot.process.pid, signal.SIGSTOP)
        try:
            await driver.stopped_for("odometry has given nothing")
            driver.commands = False
        finally:
            os.kill(robot.process.pid, signal.SIGCONT)
        await stands(robot)
        # It dies
        await driver.set_out()
        os.kill(robot.process.pid, signal.SIGKILL)
        await driver.stopped_for("odometry has given nothing")


def check_what_came(driver: Driver) -> None:
    """The streams are those of the mapping: stamps on the program's clock, the laser where the model has it."""
    scan, joints = driver.newest["hokuyo"], driver.newest["joints"]
    assert isinstance(scan, LaserScan)
    assert isinstance(joints, JointState)
    assert scan.frame == "rplidar_link"
    assert np.allclose(scan.X_BL.translation, (-0.04, 0.0, 0.19))
    # Of the room's walls, 3.9 m apart, one is always near; none is farther than its diagonal of 7.1 m.
    assert 0.15 < float(scan.ranges.min()) < 2.0
    assert float(scan.ranges.max()) < 7.2
    assert not scan.ranges.flags.writeable
    assert 0.8 < driver.newest["battery"].charge <= 0.9
    assert set(joints.names) == {"left_wheel_joint", "right_wheel_joint"}
    assert abs(odometry(driver.newest).stamp - driver.clock.now()) < 0.5 + PATIENCE_S


def survey() -> dict[str, Any]:
    """What `hbba ros map` says of the robot in this worker's domain, once it has heard all of its topics."""
    command = python("-m", "app.cli", "ros", "map", "--json", "--listen", "3", "--domain", str(domain()))
    around = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    deadline = time.monotonic() + PATIENCE_S
    while True:  # a busy computer may not hear all in time
        said = subprocess.run(command, capture_output=True, text=True, env=around, cwd=paths.config_dir().parent)
        found: dict[str, Any] = json.loads(said.stdout)
        heard = {topic["name"] for topic in found["topics"] if topic["rate_hz"]}
        if heard >= {"/odom", "/scan", "/joint_states", "/battery_state"}:
            return found
        assert time.monotonic() < deadline, f"never heard all: {found['topics']}"


async def test_simulated_time_and_a_type_that_does_not_fit(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot("--sim-time")
    found = await asyncio.to_thread(survey)
    assert (found["mapping"].count("topic: "), "clock: sim" in found["mapping"]) == (5, True)
    assert [sentence.partition(":")[0] for sentence in found["missing"]] == ["watchdog"]
    async with Ros2Driver(mapping(clock="sim")) as driver:
        await driver.set_out()
        # Its clock reads a thousand seconds; what comes of it is on the program's.
        assert abs(odometry(driver.newest).stamp - driver.clock.now()) < PATIENCE_S
        robot.fault("clock stop")
        await driver.stopped_for("clock has given nothing", "/clock")
        await stands(robot)
    config = mapping()
    config = config.model_copy(update={"base": config.base.model_copy(update={"type": "geometry_msgs/msg/Twist"})})
    config._document = mapping()._document
    line = 1 + next(n for n, text in enumerate(MAPPING.read_text("utf-8").splitlines()) if text.startswith("  type:"))
    with pytest.raises(LinkFailed) as refused:
        await Ros2Driver(config).link.start()
    assert str(refused.value) == (
        f"{MAPPING}:{line}: base.type: /cmd_vel has the type geometry_msgs/msg/TwistStamped; "
        "the mapping reads or writes geometry_msgs/msg/Twist"
    )


async def test_the_program_is_frozen_and_killed(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot()
    program = subprocess.Popen(  # noqa: ASYNC220  # its pipe is read in a thread
        [sys.executable, "-m", "tests.robots.ros2.robot", str(domain())],
        stdout=subprocess.PIPE, text=True, cwd=paths.config_dir().parent,
    )  # fmt: skip
    assert program.stdout is not None
    try:
        said, process_id = (await asyncio.to_thread(program.stdout.readline)).split()
        assert said == "driving"
        link = psutil.Process(int(process_id))
        os.kill(program.pid, signal.SIGSTOP)
        try:
            await stands(robot)
            assert link.is_running()
        finally:
            os.kill(program.pid, signal.SIGCONT)
        await asyncio.to_thread(robot.wait_for, "driving again", lambda rows: rows[-1].linear_mps > 0.1)
        os.kill(program.pid, signal.SIGKILL)
        await stands(robot)
        await asyncio.to_thread(link.wait, PATIENCE_S)
    finally:
        program.kill()
        program.wait()
        program.stdout.close()


async def test_the_links_process_dies_and_odometry_begins_again(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot("--watchdog", "0.4")
    driver = Ros2Driver(mapping())
    async with driver:
        await driver.set_out()
        await driver.wait_for("some way", lambda seen: odometry(seen).X_OB.y > 0.8)
        robot.fault("origin")
        async with asyncio.timeout(PATIENCE_S):
            failure = await driver.link.wait_failed()
        assert str(failure) == "The robot's odometry jumped: it began again, and what was built on it is void."
        await stands(robot)
        # It is started again, as the program does; then it is killed: the robot's own watchdog is all there is.
        await driver.link.start()
        await driver.set_out()
        process_id = driver.ros2.process_id
        assert process_id is not None
        os.kill(process_id, signal.SIGKILL)
        async with asyncio.timeout(PATIENCE_S):
            assert "was killed by signal 9" in str(await driver.link.wait_failed())
        await stands(robot)


async def test_a_robot_that_is_not_there_is_one_sentence() -> None:
    with pytest.raises(LinkFailed) as refused:
        await Ros2Driver(mapping(found_within_s=0.2)).link.start()
    assert str(refused.value) == (
        "TurtleBot 4 was not found within 0.2 s: odometry has given nothing yet: /odom has no publisher; "
        "nothing listens to /cmd_vel: commands do not reach the robot. Topics that are there: none."
    )
