"""The control loop of the link's process, turned by hand: what it waits for, and what waits for nothing."""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Iterator

import pytest

from app.robots.config import RobotConfig
from app.robots.simulated import link_protocol, realtime_loop
from app.robots.simulated.realtime_loop import RealtimeLoop
from app.robots.simulated.world_config import WorldConfig

TURN_S = 0.004


class SlowCamera:
    """A camera that never finishes its first picture."""

    failure = None

    def __init__(self, *_: object) -> None:
        self.finished: deque[link_protocol.ImageNotice] = deque()
        self.drawn: list[str] = []

    def wait_ready(self, timeout_s: float) -> None:
        """It is ready at once."""

    def busy(self, stream: str) -> bool:
        return stream in self.drawn

    def request(self, stream: str, snapshot: object) -> None:
        self.drawn.append(stream)


class Rings:
    """In place of the shared memory, which no picture reaches."""

    rings: None = None

    def __init__(self, *_: object) -> None:
        pass


class Turned:
    """The loop, and the program's end of its socket."""

    def __init__(self, loop: RealtimeLoop, program: socket.socket) -> None:
        self.loop, self._program, self.now = loop, program, loop._pacer.stamp

    def turns(self, count: int) -> float:
        """Simulated time (s) that passes in so many turns."""
        before = self.loop._simulation.physics.time_s
        for _ in range(count):
            self.now += TURN_S
            self.loop._turn(self.now)
        return self.loop._simulation.physics.time_s - before

    def command(self, linear_mps: float) -> None:
        self._program.sendall(link_protocol.encode(link_protocol.DriveRequest(self.now, linear_mps, 0.0)))
        self.loop._receive()

    @property
    def speed(self) -> float:
        """What the wheels are given (m/s)."""
        return self.loop._simulation.state.applied.linear_mps


@pytest.fixture
def turned(robot: RobotConfig, hall: WorldConfig, monkeypatch: pytest.MonkeyPatch) -> Iterator[Turned]:
    monkeypatch.setattr(realtime_loop, "CameraThread", SlowCamera)
    monkeypatch.setattr(realtime_loop, "ImageRings", Rings)
    mute = robot.model_copy(update={"streams": robot.streams.model_copy(update={"microphones": None})})
    program, link = socket.socketpair()
    start = link_protocol.Start(mute, hall, 0.0, {"kinect": 15.0})
    with program, link:
        yield Turned(RealtimeLoop(start, link_protocol.Socket(link), -1), program)


def test_the_world_waits_for_a_late_picture_but_setting_out_and_stopping_do_not(turned: Turned) -> None:
    assert turned.turns(25) > 0.05  # a picture is asked for, and never comes
    assert turned.turns(3) == 0.0
    turned.command(0.3)
    assert turned.turns(1) > 0.0
    assert turned.speed > 0.0
    while turned.turns(1):
        turned.command(0.3)  # the hold goes on: it is waited for pictures again
    speed = turned.speed
    turned.command(0.0)
    assert turned.turns(1) > 0.0
    assert turned.speed < speed
