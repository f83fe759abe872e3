"""A robot of parts in another process, at a pseudo-terminal and a TCP port: it is driven, and goes wrong in every way;
its base stops, the status says why, and it comes back by itself."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml

from app.base import paths
from app.link import LinkFailed
from app.messages import GamepadState, LaserScan
from app.robots.drivers.config import load_drivers_config
from tests.patience import PATIENCE_S
from tests.robots.drivers.parts import PartsDriver, Robot, body_file
from tests.robots.played import odometry

PORTRAIT = Path(__file__).parents[3] / "app" / "robots" / "simulated" / "scenery" / "faces" / "pilot.jpg"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.blocking(reason="reads the robot's log and feeds it faults; nothing else is on the loop"),
]


@pytest.fixture
def start_robot(tmp_path: Path) -> Iterator[Callable[..., Robot]]:
    """Start robots that end with the test."""
    robots: list[Robot] = []

    def start(**changes: Any) -> Robot:
        robots.append(Robot(body_file(tmp_path, **changes)))
        return robots[-1]

    yield start
    for robot in robots:
        robot.close()


async def stands(robot: Robot) -> None:
    """Wait until the robot has stood for half a second."""
    await asyncio.to_thread(
        robot.wait_for, "standing", lambda rows: len(rows) > 50 and all(r.still for r in rows[-50:])
    )


async def stand_still(robot: Robot, driver: PartsDriver) -> None:
    """Have it stand at zero commands, and its odometry where it truly is."""
    driver.velocity, driver.commands = (0.0, 0.0), True
    await driver.wait_for("zero", lambda seen: seen["status"].guard == "idle")
    await stands(robot)
    truth = robot.rows()[-1]
    await driver.wait_for(
        "odometry at the truth",
        lambda seen: math.hypot(odometry(seen).X_OB.x - truth.x, odometry(seen).X_OB.y - truth.y) < 0.03,
    )


async def test_whatever_is_pulled_its_base_stops_and_comes_back(
    start_robot: Callable[..., Robot], caplog: pytest.LogCaptureFixture
) -> None:
    robot = start_robot()
    async with PartsDriver(robot.config) as driver:
        await driver.set_out()
        await driver.wait_for("every stream", lambda seen: {"hokuyo", "joints", "battery", "gamepad"} <= seen.keys())
        scan = driver.newest["hokuyo"]
        assert isinstance(scan, LaserScan)
        # Of the room's walls, 3.9 m apart, one is always near; none is farther than its diagonal of 7.1 m.
        assert 0.1 < float(scan.ranges.min()) < 2.1
        assert float(scan.ranges.max()) < 7.3
        assert not scan.ranges.flags.writeable
        assert abs(scan.stamp - driver.clock.now()) < PATIENCE_S
        # No command any more, then an emergency stop.
        driver.commands = False
        assert (await driver.stopped_for("no fresh command")).guard == "stale_command"
        await stands(robot)
        await driver.set_out()
        driver.link.e_stop("a test")
        assert (await driver.stopped_for("emergency stop: a test")).e_stopped
        await stands(robot)
        driver.link.clear_e_stop()
        # The cable of the base: it stops by itself, and no way is lost.
        await driver.set_out()
        robot.fault("base unplug")
        status = await driver.stopped_for("base (", "it was unplugged")
        assert status.guard == "sensor_failure"
        await stands(robot)
        robot.fault("base plug")
        await stand_still(robot, driver)
        # Its voice, its ears, its button.
        for fault, end, said in (
            ("base mute", "base talk", "nothing"),
            ("base deaf", "base hear", "does not take the commands"),
            ("base faults 2", "base faults 0", "its emergency button is pressed"),
            ("hokuyo mute", "hokuyo talk", "hokuyo (tcp"),
            ("hokuyo unplug", "hokuyo plug", "it closed the connection"),
        ):
            await driver.set_out()
            robot.fault(fault)
            await driver.stopped_for(said)
            await stands(robot)
            robot.fault(end)
        # Damage to one byte in a hundred: what arrives whole is enough, and what does not moves nothing.
        await driver.set_out()
        robot.fault("base noise 0.01")
        await driver.set_out()
        robot.fault("base noise 0")
        # It was reset: its counts begin at 0, and the base stays where it was.
        await stand_still(robot, driver)
        before = odometry(driver.newest).X_OB
        robot.fault("base reset")
        await driver.wait_for("the reset", lambda _: "it began again" in caplog.text)
        later = driver.clock.now()
        await driver.wait_for("odometry after it", lambda seen: odometry(seen).stamp > later)
        assert before == odometry(driver.newest).X_OB
        await driver.set_out()
        # A gamepad's last word.
        robot.fault("gamepad BTN_TL 1")
        await driver.wait_for("the dead-man", lambda seen: seen["gamepad"].held)
        robot.fault("gamepad unplug")
        await driver.wait_for("its end", lambda seen: not seen["gamepad"].connected)
        assert driver.newest["gamepad"] == GamepadState(driver.newest["gamepad"].stamp, False, held=False, stop=False)
        robot.fault("gamepad plug")
        await driver.wait_for("its return", lambda seen: seen["gamepad"].connected)


async def test_the_guards_process_is_killed_and_the_base_stops_by_itself(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot(camera={"source": str(PORTRAIT), "link": "hokuyo_link", "rate_hz": 5})
    async with PartsDriver(robot.config) as driver:
        await driver.set_out()
        await driver.wait_for("a picture", lambda seen: "camera" in seen)
        process_id = driver.parts.process_id
        assert process_id is not None
        os.kill(process_id, signal.SIGKILL)
        async with asyncio.timeout(PATIENCE_S):
            assert "was killed by signal 9" in str(await driver.link.wait_failed())
        await stands(robot)
        # It is started again, as the program does.
        await driver.link.start()
        await driver.set_out()
        before = driver.newest["camera"].stamp
        await driver.wait_for("a later picture", lambda seen: seen["camera"].stamp > before)


async def test_the_program_is_frozen_and_killed(start_robot: Callable[..., Robot]) -> None:
    robot = start_robot()
    program = subprocess.Popen(  # noqa: ASYNC220  # its pipe is read in a thread
        [sys.executable, "-m", "tests.robots.drivers.parts", str(robot.file)],
        stdout=subprocess.PIPE, text=True, cwd=paths.config_dir().parent,
    )  # fmt: skip
    assert program.stdout is not None
    try:
        said, process_id = (await asyncio.to_thread(program.stdout.readline)).split()
        assert said == "driving"
        guard = psutil.Process(int(process_id))
        os.kill(program.pid, signal.SIGSTOP)
        try:
            await stands(robot)
            assert guard.is_running()
        finally:
            os.kill(program.pid, signal.SIGCONT)
        await asyncio.to_thread(robot.wait_for, "driving again", lambda rows: rows[-1].linear_mps > 0.1)
        os.kill(program.pid, signal.SIGKILL)
        await stands(robot)
        await asyncio.to_thread(guard.wait, PATIENCE_S)
    finally:
        program.kill()
        program.wait()
        program.stdout.close()


async def refused(folder: Path, **changes: Any) -> str:
    """Why a body cannot start."""
    file = body_file(folder)
    text = yaml.safe_load(file.read_text("utf-8")) | changes
    file.write_text(yaml.safe_dump(text), "utf-8")
    with pytest.raises(LinkFailed) as failure:
        await PartsDriver(load_drivers_config(file)).link.start()
    return str(failure.value)


async def test_what_is_not_there_and_what_is_another_device_are_one_sentence(
    tmp_path: Path, start_robot: Callable[..., Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.robots.drivers.link.START_TIMEOUT_S", PATIENCE_S)
    said = await refused(tmp_path, found_within_s=0.2)
    where = f"base ({tmp_path / 'base'})"
    assert said.startswith(f"Serial base was not found within 0.2 s: {where}: there is no such device: is it plugged")
    robot = start_robot()
    robot.fault("base wrong $GPGGA,120000")
    async with asyncio.timeout(PATIENCE_S):
        with pytest.raises(LinkFailed) as failure:
            await PartsDriver(robot.config).link.start()
    assert f"{where}: no base answers (docs/serial-base.md): it said b'" in str(failure.value)
    assert "GPGGA" in str(failure.value)
