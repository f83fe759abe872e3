"""Protocol between the program and the link's process: framed messages over a socket pair, never blocking either side.

A frame is its length (4 bytes, little endian) and a pickle; both ends are this program, and the socket is private. A
full socket means a frozen reader: the writer drops its oldest unsent frames and counts them.
"""

from __future__ import annotations

import contextlib
import pickle
import socket
import struct
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from app.base.geometry import Pose3
from app.messages import Audio, JointCommand, Twist
from app.robots.config import RobotConfig
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig

_LENGTH = struct.Struct("<I")
_READ_BYTES = 65536


@dataclass(frozen=True, slots=True)
class Start:
    """Program to link, first: all the link needs. ``clock_offset`` makes the robot's clock of ``monotonic()``;
    ``demanded``: rates (Hz) by stream. ``e_stop`` is the reason of an emergency stop that is latched already, or None.
    """

    robot: RobotConfig
    world: WorldConfig
    clock_offset: float
    demanded: Mapping[str, float]
    e_stop: str | None = None
    scenario: ScenarioConfig | None = None


@dataclass(frozen=True, slots=True)
class Demand:
    """Program to link: the rate (Hz) at which ``stream`` is wanted, 0 for not."""

    stream: str
    rate_hz: float


@dataclass(frozen=True, slots=True)
class ComputerLoad:
    """Program to link: how many ``cores`` of the robot's computer are busy, on average since the last."""

    cores: float


@dataclass(frozen=True, slots=True)
class DriveRequest:
    """Program to link: a commanded velocity, at ``stamp`` (s, robot's clock)."""

    stamp: float
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Play:
    """Program to link: sound for the loudspeaker."""

    audio: Audio


@dataclass(frozen=True, slots=True)
class EStopRequest:
    """Program to link: latch the emergency stop."""

    reason: str


@dataclass(frozen=True, slots=True)
class ClearEStop:
    """Program to link: release the latch."""


@dataclass(frozen=True, slots=True)
class Stop:
    """Program to link: stop the wheels and end."""


@dataclass(frozen=True, slots=True)
class Ready:
    """Link to program: the world runs. ``setup_s`` is how long it took to build."""

    setup_s: float


@dataclass(frozen=True, slots=True)
class Sample:
    """Link to program: one message of a stream."""

    stream: str
    message: Any


@dataclass(frozen=True, slots=True, eq=False)
class ImageNotice:
    """Link to program: an image of ``stream`` is in ``slot`` of the shared ring, written as number ``sequence``.

    It ends so many ``periods`` of the stream: its own, and those that were left out before it.
    """

    stream: str
    slot: int
    sequence: int
    stamp: float
    X_BC: Pose3
    periods: int = 1


def request(command: Twist | JointCommand) -> DriveRequest | JointCommand:
    """``command`` as it goes over the socket."""
    if isinstance(command, JointCommand):
        return command
    return DriveRequest(command.stamp, command.linear_mps, command.angular_radps, command.lateral_mps)


def encode(frame: Any) -> bytes:
    payload = pickle.dumps(frame, protocol=5)
    return _LENGTH.pack(len(payload)) + payload


class FrameReader:
    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Any]:
        """Add ``data``; return the frames that are complete now, in order."""
        self._buffer += data
        frames: list[Any] = []
        start = 0
        while len(self._buffer) - start >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(self._buffer, start)
            end = start + _LENGTH.size + length
            if len(self._buffer) < end:
                break
            frames.append(pickle.loads(bytes(self._buffer[start + _LENGTH.size : end])))
            start = end
        del self._buffer[:start]
        return frames


class Socket:
    """The link process's end: reads and writes frames of a non-blocking socket; ``capacity`` unsent frames at most."""

    def __init__(self, sock: socket.socket, capacity: int = 64) -> None:
        self._socket = sock
        self._socket.setblocking(False)
        self._reader = FrameReader()
        self._waiting: deque[bytes] = deque()
        self._capacity = capacity
        self._partial = b""
        self.dropped = 0
        self.closed = False

    def fileno(self) -> int:
        return self._socket.fileno()

    @property
    def has_unsent(self) -> bool:
        """Whether :meth:`flush` has something to write."""
        return bool(self._partial or self._waiting)

    def receive(self) -> list[Any]:
        """Every frame that has arrived; sets ``closed`` when the other end is gone."""
        frames: list[Any] = []
        while not self.closed:
            try:
                data = self._socket.recv(_READ_BYTES)
            except BlockingIOError:
                break
            except ConnectionError:
                data = b""
            if not data:
                self.closed = True
            frames += self._reader.feed(data)
            if len(data) < _READ_BYTES:
                break
        return frames

    def send(self, frame: Any) -> None:
        """Queue ``frame`` for :meth:`flush`; a full queue loses its oldest frame."""
        if len(self._waiting) >= self._capacity:
            self._waiting.popleft()
            self.dropped += 1
        self._waiting.append(encode(frame))

    def flush(self) -> None:
        while self.has_unsent and not self.closed:
            if not self._partial:
                self._partial = self._waiting.popleft()
            try:
                sent = self._socket.send(self._partial)
            except BlockingIOError:
                return
            except ConnectionError:
                self.closed = True
                return
            self._partial = self._partial[sent:]

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._socket.close()
