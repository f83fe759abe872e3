"""Protocol between the program and the process of a body: framed messages over a socket pair, never blocking either
side.

A frame is its length (4 bytes, little endian) and a pickle; both ends are this program, and the socket is private. A
full socket means a frozen reader: the writer drops its oldest unsent frames and counts them.
"""

from __future__ import annotations

import contextlib
import pickle
import socket
import struct
from collections import deque
from dataclasses import dataclass
from typing import Any

from app.messages import JointCommand, Twist

_LENGTH = struct.Struct("<I")
_READ_BYTES = 65536


@dataclass(frozen=True, slots=True)
class Demand:
    """Program to link: the rate (Hz) at which ``stream`` is wanted, 0 for not."""

    stream: str
    rate_hz: float


@dataclass(frozen=True, slots=True)
class DriveRequest:
    """Program to link: a commanded velocity, at ``stamp`` (s, robot's clock)."""

    stamp: float
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


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
    """Link to program: the body runs. ``setup_s`` is how long that took."""

    setup_s: float


@dataclass(frozen=True, slots=True)
class Sample:
    """Link to program: one message of a stream."""

    stream: str
    message: Any


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
