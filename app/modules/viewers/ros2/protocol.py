"""What the program and its process in the graph say to each other: frames over a private socket.

A frame is its length (4 bytes, little endian) and MessagePack. Messages of ROS are CDR, with encapsulation.
"""

from __future__ import annotations

import struct

import msgspec

_LENGTH = struct.Struct("<I")


class Topic(msgspec.Struct, frozen=True):
    """A topic to be offered: its ``name`` and ``type``; ``latched``: late readers get the last message."""

    name: str
    type: str
    latched: bool = False


class Service(msgspec.Struct, frozen=True):
    """A service to be offered; ``request`` and ``response`` are the lines of its ``.srv`` file."""

    name: str
    type: str
    request: str
    response: str


class Open(msgspec.Struct, frozen=True, tag=True):
    """Program to process, first: what to offer. ``definitions``: names and texts of the types that are in no package of
    ROS 2's own, those that others use first; ``domain``: None for the environment's."""

    node: str
    domain: int | None
    definitions: tuple[tuple[str, str], ...]
    topics: tuple[Topic, ...]
    services: tuple[Service, ...]


class Publish(msgspec.Struct, frozen=True, tag=True):
    """Program to process: a message on the topic of this number."""

    topic: int
    data: bytes


class Answer(msgspec.Struct, frozen=True, tag=True):
    """Program to process: the response to a call."""

    call: int
    data: bytes


class Stop(msgspec.Struct, frozen=True, tag=True):
    """Program to process: leave the graph."""


class Ready(msgspec.Struct, frozen=True, tag=True):
    """Process to program: all is offered, but for what is ``left_out`` (topics' and services' names, why)."""

    left_out: tuple[tuple[str, str], ...] = ()


class Shown(msgspec.Struct, frozen=True, tag=True):
    """Process to program: so many listen to the topic of this number now."""

    topic: int
    readers: int


class Call(msgspec.Struct, frozen=True, tag=True):
    """Process to program: a call of the service of this number."""

    call: int
    service: int
    data: bytes


ToProcess = Open | Publish | Answer | Stop
ToProgram = Ready | Shown | Call
_encoder = msgspec.msgpack.Encoder()


def encode(message: ToProcess | ToProgram) -> bytes:
    """The frame of ``message``."""
    data = _encoder.encode(message)
    return _LENGTH.pack(len(data)) + data


class Frames:
    """Takes frames out of a stream of bytes."""

    def __init__(self, side: type[ToProcess] | type[ToProgram]) -> None:
        self._decoder = msgspec.msgpack.Decoder(side)
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[ToProcess | ToProgram]:
        """The messages that are complete with ``data``, in order."""
        self._buffer += data
        found: list[ToProcess | ToProgram] = []
        start = 0
        while len(self._buffer) - start >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(self._buffer, start)
            end = start + _LENGTH.size + length
            if len(self._buffer) < end:
                break
            found.append(self._decoder.decode(memoryview(self._buffer)[start + _LENGTH.size : end]))
            start = end
        del self._buffer[:start]
        return found
