"""The body of a log: what it delivers, when, to whom, and what it does not even read."""

from __future__ import annotations

import asyncio
import math
import threading
from pathlib import Path
from typing import Any

import pytest

from app.link import BaseLimits, LinkFailed, RobotDescription, StreamDescription
from app.logs.log import Logged
from app.messages import Image, JointState, LaserScan, LinkStatus, Odometry, Twist
from app.robots.replayed.link import ReplayedLink
from app.runtime.clock import Clock, VirtualClock, in_virtual_time, run_virtual
from app.runtime.replay_clock import ReplayClock
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_messages, numbered
from tests.patience import PATIENCE_S

CHANNELS = {"odometry": "odometry", "joints": "joints", "status": "link_status", "kinect": "kinect", "hokuyo": "scan"}
TYPES = {"odometry": Odometry, "joints": JointState, "status": LinkStatus, "kinect": Image, "hokuyo": LaserScan}


def made(log: MemoryLog, clock: Clock, **more: Any) -> ReplayedLink:
    streams = {name: StreamDescription(name, kind, 10.0) for name, kind in TYPES.items()}
    limits = BaseLimits(0.4, 1.0, 0.4, 4.0)
    description = RobotDescription("a recorded robot", Path("none.urdf"), limits, streams, simulated=False)
    return ReplayedLink(log, clock, description, CHANNELS, **more)


class Listener:
    """Remembers what comes, and when."""

    def __init__(self, clock: Clock) -> None:
        self.came: list[tuple[float, Any]] = []
        self._clock = clock

    def __call__(self, message: Any) -> None:
        self.came.append((self._clock.now(), message))

    @property
    def xs(self) -> list[float]:
        return [message.X_OB.x for _, message in self.came]


@in_virtual_time
async def test_each_message_comes_at_its_time_and_in_order() -> None:
    log = MemoryLog(numbered(50))
    clock = VirtualClock(BEGIN)
    body = made(log, clock)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.start()
    await body.finished.wait()
    assert [message for _, message in listener.came] == [logged.message for logged in log.messages()]
    assert [at for at, _ in listener.came] == pytest.approx([logged.at for logged in log.messages()], abs=1e-5)
    assert all(at >= logged.at for (at, _), logged in zip(listener.came, log.messages(), strict=True))
    await body.stop()


@in_virtual_time
async def test_an_unwanted_stream_is_not_decoded() -> None:
    log = MemoryLog(lab_messages(3.0))
    clock = VirtualClock(BEGIN)
    body = made(log, clock)
    odometry, kinect = Listener(clock), Listener(clock)
    body.attach("odometry", odometry)
    body.attach("kinect", kinect)
    await body.start()
    await clock.sleep_until(BEGIN + 1.0)
    assert kinect.came == []
    assert "kinect" not in log.decoded
    body.demand("kinect", math.inf)
    await clock.sleep_until(BEGIN + 2.0)
    body.demand("kinect", 0.0)
    await body.finished.wait()
    # Of the second in between everything, of the others nothing; and odometry misses nothing by it.
    expected = [logged.message for logged in log.messages(channels={"kinect"}) if 1.0 <= logged.at - BEGIN <= 2.0]
    assert [message for _, message in kinect.came] == expected
    assert len(odometry.came) == 150
    await body.stop()


@in_virtual_time
async def test_what_had_no_listener_for_long_does_not_come_late() -> None:
    log = MemoryLog(numbered(100))
    clock = VirtualClock(BEGIN)
    body = made(log, clock)
    await body.start()
    await clock.sleep_until(BEGIN + 4.95)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.finished.wait()
    assert listener.xs == [float(i) for i in range(50, 100)]
    await body.stop()


@in_virtual_time
async def test_from_and_to() -> None:
    clock = VirtualClock(BEGIN + 2.0)
    body = made(MemoryLog(numbered(100)), clock, begin=BEGIN + 2.0, end=BEGIN + 3.0)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.start()
    await body.finished.wait()
    assert listener.xs == [float(i) for i in range(20, 31)]
    await body.stop()


@in_virtual_time
async def test_seeking_goes_on_behind_the_place() -> None:
    """Back and forth; the message at the place itself has gone by."""
    clock = ReplayClock(BEGIN)
    body = made(MemoryLog(numbered(100)), clock)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.start()
    for position, until, expected in ((5.0, 5.35, [51, 52, 53]), (1.05, 1.2, [11, 12])):
        clock.jump(BEGIN + position)
        body.seek(BEGIN + position)
        assert body.reading
        await idle(body)
        listener.came.clear()
        clock.advance_to(BEGIN + until)
        await came(listener, len(expected))
        assert listener.xs == expected
    await body.stop()


async def idle(body: ReplayedLink) -> None:
    """Wait until the body waits for its clock."""
    async with asyncio.timeout(PATIENCE_S):
        while body.reading:  # noqa: ASYNC110  # each turn lets the body go on
            await asyncio.sleep(0)


async def came(listener: Listener, count: int) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while len(listener.came) < count:  # noqa: ASYNC110  # each turn lets the body go on
            await asyncio.sleep(0)


async def test_a_clock_that_stands_delivers_nothing_on_a_real_loop() -> None:
    clock = ReplayClock(BEGIN - 1.0)
    body = made(MemoryLog(numbered(30)), clock)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.start()
    await idle(body)
    assert listener.came == []
    clock.advance_to(BEGIN + 10.0)
    async with asyncio.timeout(PATIENCE_S):
        await body.finished.wait()
    assert listener.xs == [float(i) for i in range(30)]
    await body.stop()


@in_virtual_time
async def test_held_until_released() -> None:
    clock = VirtualClock(BEGIN)
    body = made(MemoryLog(numbered(10)), clock, hold=True)
    listener = Listener(clock)
    body.attach("odometry", listener)
    await body.start()
    await clock.sleep(0.0)
    assert not body.reading
    assert listener.came == []
    body.release()
    await body.finished.wait()
    assert len(listener.came) == 10
    await body.stop()


@in_virtual_time
async def test_a_damaged_log_is_a_failed_body() -> None:
    log = MemoryLog(numbered(30), damaged_at=BEGIN + 1.05)
    clock = VirtualClock(BEGIN)
    body = made(log, clock)
    body.attach("odometry", Listener(clock))
    await body.start()
    failure = await body.wait_failed()
    assert isinstance(failure, LinkFailed)
    assert "is damaged" in str(failure)
    assert not body.finished.is_set()
    await body.stop()


@in_virtual_time
async def test_the_wheels_of_the_past_cannot_be_driven() -> None:
    clock = VirtualClock(BEGIN)
    body = made(MemoryLog(numbered(3)), clock)
    await body.start()
    body.command(Twist(BEGIN, 1.0, 0.0))
    body.e_stop("a test")
    body.clear_e_stop()
    with pytest.raises(KeyError, match="no stream 'sonar'; it has odometry"):
        body.attach("sonar", print)
    await body.stop()
    await body.stop()


@in_virtual_time
async def test_reading_never_happens_on_the_loop_nor_in_two_threads() -> None:
    log = MemoryLog(lab_messages(2.0))
    clock = VirtualClock(BEGIN)
    body = made(log, clock)
    body.attach("odometry", lambda _: None)
    body.attach("kinect", lambda _: None)
    await body.start()
    for i in range(8):
        await clock.sleep(0.2)
        body.demand("kinect", math.inf if i % 2 == 0 else 0.0)
    await body.finished.wait()
    assert len(log.readers) == 1
    assert threading.get_ident() not in log.readers
    await body.stop()


@in_virtual_time
async def test_a_receiver_that_fails_does_not_cut_off_the_next() -> None:
    contexts: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: contexts.append(context))
    clock = VirtualClock(BEGIN)
    body = made(MemoryLog(numbered(2)), clock)

    def broken(_: Any) -> None:
        raise ZeroDivisionError

    listener = Listener(clock)
    body.attach("odometry", broken)
    body.attach("odometry", listener)
    await body.start()
    await body.finished.wait()
    assert len(listener.came) == 2
    assert [str(context["message"]) for context in contexts] == ["a receiver of odometry raised"] * 2
    await body.stop()


def test_many_at_one_instant_come_the_same_in_every_run() -> None:
    """Equal times, streams coming and going: two runs deliver the same at the same times."""

    def once() -> list[tuple[float, str, float]]:
        messages = sorted(
            [Logged(BEGIN + i // 7 / 10, channel, message.message)
             for channel in ("odometry", "scan") for i, message in enumerate(numbered(140, channel=channel))],
            key=lambda logged: logged.at,
        )  # fmt: skip
        log = MemoryLog(messages)
        seen: list[tuple[float, str, float]] = []

        async def main() -> None:
            clock = VirtualClock(BEGIN)
            body = made(log, clock)
            body.attach("odometry", lambda m: seen.append((clock.now(), "odometry", m.X_OB.x)))
            body.attach("hokuyo", lambda m: seen.append((clock.now(), "scan", m.X_OB.x)))
            await body.start()
            for i in range(12):
                await clock.sleep(0.1)
                body.demand("hokuyo", math.inf if i % 3 != 2 else 0.0)
            await body.finished.wait()
            await body.stop()

        run_virtual(main())
        return seen

    first = once()
    assert [x for _, name, x in first if name == "odometry"] == [float(i) for i in range(140)]
    assert first == once()
