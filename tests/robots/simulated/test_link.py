"""The link as the program sees it: streams, demand, driving, faults, and nothing left behind."""

from __future__ import annotations

import asyncio
import itertools
import math
import os
import signal
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from app.base.geometry import FisheyeModel
from app.link import LinkFailed
from app.messages import BatteryState, GroundTruth, Image, LaserScan, LinkStatus, Odometry, Twist
from app.robots.config import RobotConfig
from app.robots.simulated import link as link_module
from app.robots.simulated.gl import MISSING_EGL
from app.robots.simulated.guard_log import read_guard_log
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.world_config import WorldConfig
from tests.patience import PATIENCE_S
from tests.robots.conftest import needs_gl
from tests.robots.simulated.shared_memory import shared_memory

OFFSET = time.time() - time.monotonic()
SENSORS = ("kinect", "panorama", "hokuyo", "ground_truth", "scene_truth", "microphones")

pytestmark = pytest.mark.slow


def now() -> float:
    return time.monotonic() + OFFSET


def without_camera(robot: RobotConfig) -> RobotConfig:
    return robot.model_copy(update={"streams": robot.streams.model_copy(update={"kinect": None, "panorama": None})})


class Listener:
    """Collects everything a link gives."""

    def __init__(self, link: SimulatedLink) -> None:
        self.link = link
        self.messages: dict[str, list[Any]] = {name: [] for name in link.description.streams}
        self._arrived = asyncio.Event()
        for name in link.description.streams:
            link.attach(name, self._receiver(name))

    def _receiver(self, name: str) -> Callable[[Any], None]:
        def receive(message: Any) -> None:
            self.messages[name].append(message)
            self._arrived.set()

        return receive

    async def until(self, found: Callable[[], object], timeout_s: float = PATIENCE_S) -> None:
        async with asyncio.timeout(timeout_s):
            while not found():
                self._arrived.clear()
                await self._arrived.wait()

    async def next(self, stream: str, count: int = 1) -> Any:
        wanted = len(self.messages[stream]) + count
        await self.until(lambda: len(self.messages[stream]) >= wanted)
        return self.messages[stream][-1]

    async def drive(self, linear: float, angular: float, seconds: float) -> None:
        """Command at 20 Hz for ``seconds`` of the robot's own time."""
        start = (await self.next("odometry")).stamp
        while self.messages["odometry"][-1].stamp - start < seconds:
            self.link.command(Twist(now(), linear, angular))
            await self.next("odometry", 5)


@pytest.fixture
async def blind(robot: RobotConfig, hall: WorldConfig) -> AsyncIterator[Listener]:
    """A running robot without a camera in the empty hall."""
    start = robot.start.model_copy(update={"x": 10.0, "y": 10.0, "heading_deg": 0.0})
    link = SimulatedLink(without_camera(robot).model_copy(update={"start": start}), hall, OFFSET)
    listener = Listener(link)
    await link.start()
    yield listener
    await link.stop()


async def note_lateness(late_s: list[float]) -> None:
    """Note how late (s) this process's event loop is, until cancelled."""
    while True:
        due = time.monotonic() + 0.02
        await asyncio.sleep(0.02)
        late_s.append(time.monotonic() - due)


@needs_gl
async def test_every_stream_runs_at_its_rate_in_real_time_and_unwanted_ones_not(
    robot: RobotConfig, lab: WorldConfig, tmp_path: Path
) -> None:
    guard_log = tmp_path / "guard.log"
    link = SimulatedLink(robot.model_copy(update={"guard_log": guard_log}), lab, OFFSET)
    listener = Listener(link)
    await link.start()
    late_s: list[float] = []
    watching = asyncio.create_task(note_lateness(late_s))
    try:
        await listener.next("odometry", 30)
        assert not any(listener.messages[name] for name in SENSORS)
        for name in SENSORS:
            link.demand(name, math.inf)
        await listener.next("kinect", 3)
        await listener.next("panorama", 3)
        await listener.next("microphones", 3)
        marks = {name: len(messages) for name, messages in listener.messages.items()}
        begin = time.monotonic()
        await listener.until(lambda: time.monotonic() - begin > 3.0)
        statuses: list[LinkStatus] = listener.messages["status"][marks["status"] + 20 :]
        world_rate = float(np.mean([status.world_rate for status in statuses]))
        assert 0.05 < world_rate < 1.2  # a busy computer slows the world down, and all alike
        # Odometry is a matter of physics alone: it says how much time went by in the world.
        odometry_hz = link.description.streams["odometry"].rate_hz
        world_s = (len(listener.messages["odometry"]) - marks["odometry"]) / odometry_hz
        for name, description in link.description.streams.items():
            if name in ("status", "battery", "loudspeaker"):  # not asked for; the loudspeaker's comes while it plays
                continue
            rate = (len(listener.messages[name]) - marks[name]) / world_s
            # A computer so busy that a picture takes half a second loses some.
            low = 0.15 if name in ("kinect", "panorama", "microphones") and world_rate < 0.9 else 0.8
            assert low * description.rate_hz <= rate <= 1.2 * description.rate_hz + 1, name
        rows = await asyncio.to_thread(read_guard_log, guard_log)
        gaps_s = np.diff([row.monotonic_s for row in rows if row.monotonic_s > begin])
        assert np.percentile(gaps_s, 10) < 0.010  # drawing does not hold up the guard, whatever else the computer does
        for stream, messages in listener.messages.items():
            stamps = [m.stamp for m in messages]
            assert stamps == sorted(stamps), stream
            assert stream in ("battery", "loudspeaker") or stamps[-1] > begin + OFFSET, stream
        image: Image = listener.messages["kinect"][-1]
        assert image.color.shape == (480, 640, 3)
        assert image.color.dtype == np.uint8
        assert image.depth is not None
        assert image.depth.dtype == np.uint16
        assert not image.color.flags.writeable
        assert not image.depth.flags.writeable
        assert image.X_BC.translation[2] == pytest.approx(1.38, abs=0.03)
        panorama: Image = listener.messages["panorama"][-1]
        assert panorama.color.shape == (768, 1024, 3)
        assert panorama.depth is None
        assert not panorama.color.flags.writeable
        assert panorama.camera == FisheyeModel.from_fov(1024, 768, math.pi, math.pi)
        assert panorama.frame == "panorama_optical_frame"
        np.testing.assert_allclose(panorama.X_BC.rotation[:, 2], (1, 0, 0), atol=1e-9)  # looks ahead, level
        scan: LaserScan = listener.messages["hokuyo"][-1]
        assert not scan.ranges.flags.writeable
        assert (image.frame, scan.frame) == ("kinect_optical_frame", "hokuyo_link")

        for name in SENSORS:
            link.demand(name, 0.0)
        # On a busy computer some are under way for long: the last one has come when none comes for a while.
        before: dict[str, int] = {}
        while before != (counts := {name: len(listener.messages[name]) for name in SENSORS}):
            before = counts
            await listener.next("status", 6)
        # An image waits in its ring for some periods of the camera: only a late reader finds it overwritten.
        assert link.images_overwritten == 0 or max(late_s) > 0.1
    finally:
        watching.cancel()
        await link.stop()


@needs_gl
async def test_a_camera_gives_what_is_demanded_and_says_how_many_it_left_out(
    robot: RobotConfig, lab: WorldConfig
) -> None:
    link = SimulatedLink(robot, lab, OFFSET)
    listener = Listener(link)
    periods: list[int] = []
    link.attach("kinect", lambda _: periods.append(link.periods("kinect")))
    rate_hz = link.description.streams["kinect"].rate_hz
    link.demand("kinect", rate_hz / 4)
    await link.start()
    try:
        await listener.next("kinect", 4)
        link.demand("kinect", math.inf)
        await listener.until(lambda: periods[-2:] == [1, 1])
    finally:
        await link.stop()
    assert periods[:4] == [1, 4, 4, 4]
    stamps = [image.stamp for image in listener.messages["kinect"]]
    assert all(after - before > 3.5 / rate_hz for before, after in itertools.pairwise(stamps[:4]))


async def test_it_drives_as_commanded_and_odometry_drifts_a_little(blind: Listener) -> None:
    blind.link.demand("ground_truth", math.inf)
    before: GroundTruth = await blind.next("ground_truth")
    assert blind.messages["odometry"][0].X_OB.__class__() == blind.messages["odometry"][0].X_OB
    await blind.drive(0.4, 0.0, 2.5)
    await blind.drive(0.0, 0.0, 1.3)
    after: GroundTruth = await blind.next("ground_truth")
    odometry: Odometry = await blind.next("odometry")
    travelled = (before.X_WB.inverse() @ after.X_WB).x
    # the exact metre is test_body's: here a busy computer may send commands late, and the guard stops in between
    assert 0.4 < travelled < 1.15
    assert odometry.X_OB.x == pytest.approx(travelled, rel=0.03)
    assert odometry.X_OB.x != travelled
    assert abs(odometry.linear_mps) < 0.01
    speeds = [m.linear_mps for m in blind.messages["ground_truth"]]
    assert max(speeds) < 0.41
    assert {s.guard for s in blind.messages["status"]} >= {"idle", "driving"}


async def test_e_stop_latches_until_cleared_and_says_why(blind: Listener) -> None:
    await blind.drive(0.3, 0.0, 0.5)
    blind.link.e_stop("a test")
    await blind.drive(0.3, 0.0, 0.4)
    status: LinkStatus = blind.messages["status"][-1]
    assert (status.guard, status.e_stopped, status.reason) == ("e_stopped", True, "emergency stop: a test")
    assert status.applied.linear_mps == 0
    assert abs(blind.messages["odometry"][-1].linear_mps) < 0.02
    blind.link.clear_e_stop()
    await blind.until(lambda: not blind.messages["status"][-1].e_stopped)
    assert blind.messages["status"][-1].applied.linear_mps == 0
    blind.messages["status"].clear()
    while not any(status.guard == "driving" for status in blind.messages["status"]):
        await blind.drive(0.3, 0.0, 0.5)  # on a busy computer a command may be stale when it comes


async def test_a_command_that_is_no_number_stops_the_wheels_and_is_reported(blind: Listener) -> None:
    await blind.drive(0.3, 0.0, 0.4)
    blind.link.command(Twist(now(), float("nan"), 0.0))
    await blind.until(lambda: "not a number" in blind.messages["status"][-1].reason)
    assert blind.messages["status"][-1].applied.linear_mps == 0


async def test_stop_leaves_nothing_behind_and_is_idempotent(robot: RobotConfig, hall: WorldConfig) -> None:
    ours = shared_memory(psutil.Process())
    descriptors = psutil.Process().num_fds()
    link = SimulatedLink(without_camera(robot), hall, OFFSET)
    for _ in range(2):  # and it can be started again
        await link.start()
        process = psutil.Process(link.process_id)
        shared = shared_memory(process) | shared_memory(psutil.Process())
        await link.stop()
        await link.stop()
        assert not process.is_running()
        assert {file for file in shared - ours if file.exists()} == set()
    await asyncio.sleep(0)
    assert psutil.Process().num_fds() <= descriptors + 1


async def test_a_killed_link_is_noticed_at_once(blind: Listener) -> None:
    blind.link.e_stop("before the crash")
    failed = asyncio.create_task(blind.link.wait_failed())
    await asyncio.sleep(0)
    assert blind.link.process_id is not None
    os.kill(blind.link.process_id, signal.SIGKILL)
    async with asyncio.timeout(PATIENCE_S):
        failure = await failed
    assert isinstance(failure, LinkFailed)
    assert "killed by signal 9" in str(failure)
    blind.messages["status"].clear()
    await blind.link.start()  # the same link starts again, and an emergency stop has outlived the crash
    await blind.until(lambda: blind.messages["status"])
    assert blind.messages["status"][-1].reason == "emergency stop: before the crash"


async def test_a_frozen_link_never_blocks_the_program(blind: Listener) -> None:
    process_id = blind.link.process_id
    assert process_id is not None
    os.kill(process_id, signal.SIGSTOP)
    try:
        for _ in range(20000):
            blind.link.command(Twist(now(), 0.1, 0.0))
        assert blind.link.commands_dropped > 0
    finally:
        os.kill(process_id, signal.SIGCONT)
    count = len(blind.messages["odometry"])
    await blind.until(lambda: len(blind.messages["odometry"]) > count + 20)


async def test_a_receiver_that_raises_does_not_cut_off_the_others(blind: Listener) -> None:
    problems: list[Any] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: problems.append(context))

    def broken(_: Any) -> None:
        raise RuntimeError("broken receiver")

    detach = blind.link.attach("odometry", broken)
    await blind.next("odometry", 3)
    detach()
    assert problems
    assert "a receiver of odometry raised" in problems[0]["message"]
    before = Counter(len(problems) for _ in range(1))
    await blind.next("odometry", 3)
    assert Counter([len(problems)]) == before


async def test_without_egl_one_sentence_says_what_to_install(
    robot: RobotConfig, hall: WorldConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link_module, "check_gl", lambda: MISSING_EGL)
    with pytest.raises(LinkFailed, match="install `libegl1`"):
        await SimulatedLink(robot, hall, OFFSET).start()


async def test_a_world_that_cannot_be_built_fails_the_start_with_its_reason(
    robot: RobotConfig, hall: WorldConfig, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bad = tmp_path / "bad.urdf"
    bad.write_text("<robot name='x'><link name='base_link'/></robot>")  # nothing in it has a mass
    link = SimulatedLink(without_camera(robot).model_copy(update={"model": bad}), hall, OFFSET)
    with pytest.raises(LinkFailed) as failed:
        await link.start()
    assert "cannot be simulated" in str(failed.value)
    assert "bad.urdf" in str(failed.value)
    assert not caplog.records, "the caller gets the error, and logs it once"
    assert link.process_id is None


async def test_the_programs_own_cpu_time_draws_on_the_battery(blind: Listener, robot: RobotConfig) -> None:
    assert robot.battery is not None
    load = robot.battery.load
    blind.link.demand("battery", math.inf)
    at_rest = load.idle_w + load.computer_w + 0.5  # half a watt: a twentieth of a core

    def busy() -> bool:
        sum(range(200_000))  # this process is the robot's computer
        states: list[BatteryState] = blind.messages["battery"]
        return any(state.voltage_v * -state.current_a > at_rest for state in states)

    await blind.until(busy)
