"""SCIP 2, the protocol of Hokuyo's laser range finders: pure functions between bytes and values.

A command is a line; its reply is blocks that end in an empty line: the command repeated, a status of two characters,
and lines of data, each followed by the character of its sum. A value is written in 2, 3 or 4 characters of 6 bits each,
the highest first, 0x30 added to each; values run on over the ends of lines, which have 64 characters at most.

Source: Hokuyo, "Communication Protocol Specification for SCIP 2.0" (URG series, 2006) and "UTM-30LX-EW" (2012).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: A line of data has no more characters than these, beside its sum.
LINE = 64
#: No reply is longer: 2161 steps with intensities are 13 kB.
MOST_BYTES = 65536
#: Commands whose replies are ``NAME:value;`` lines.
TABLES = ("VV", "PP", "II")
#: Statuses of a reply: the command was taken; a scan follows.
TAKEN, SCAN = "00", "99"
_VALUE = re.compile(r"([^:;]+):([^;]*);?")


class Garbled(ValueError):
    """Bytes that are no reply, or one that was damaged on its way; the message is for people."""


def checksum(line: bytes) -> bytes:
    """The character of the sum of ``line``."""
    return bytes(((sum(line) & 0x3F) + 0x30,))


def encode(values: NDArray[np.int64], characters: int) -> bytes:
    """``values`` (N,), each from 0 to 64**characters - 1, in so many characters each. Raises ValueError beyond that."""
    if values.size and not (values.min() >= 0 and values.max() < 64**characters):
        raise ValueError(f"{characters} characters hold 0 to {64**characters - 1}")
    shifts = 6 * np.arange(characters - 1, -1, -1)
    return (((values[:, None] >> shifts) & 0x3F) + 0x30).astype(np.uint8).tobytes()


def decode(data: bytes, characters: int) -> NDArray[np.int64]:
    """The values (N,) in ``data``. Raises Garbled for characters that encode nothing, and a part of a value."""
    found = np.frombuffer(data, np.uint8).astype(np.int64) - 0x30
    if found.size % characters:
        raise Garbled(f"{found.size} characters are no whole number of values of {characters} each")
    if found.size and not (found.min() >= 0 and found.max() < 64):
        raise Garbled("a character encodes no 6 bits")
    return np.asarray(found.reshape(-1, characters) @ 64 ** np.arange(characters - 1, -1, -1))


@dataclass(frozen=True, slots=True)
class Reply:
    """A reply, its sums checked and taken off. ``command`` is the line that it repeats; ``began``: when (s) its first
    byte came."""

    command: str
    status: str
    lines: tuple[bytes, ...]
    began: float

    @property
    def code(self) -> str:
        """The command's two characters."""
        return self.command[:2]


def parse(block: bytes, began: float) -> Reply:
    """The reply in ``block``, which is without the empty line at its end. Raises Garbled."""
    lines = block.split(b"\n")
    if len(lines) < 2 or not lines[0].isascii():
        raise Garbled("it is no reply of SCIP 2")
    command = lines[0].decode()
    status = _checked(lines[1])
    if len(status) != 2 or not status.isalnum():
        raise Garbled(f"the status of {command[:2]} is no status")
    table = command[:2] in TABLES
    return Reply(command, status.decode(), tuple(_checked(line, table=table) for line in lines[2:]), began)


def _checked(line: bytes, *, table: bool = False) -> bytes:
    """``line`` without its sum, which in a table is that of what is before the semicolon. Raises Garbled."""
    text = line[:-1]
    summed = text.removesuffix(b";") if table else text
    if len(line) < 2 or checksum(summed) != line[-1:]:
        raise Garbled("the sum of a line is wrong")
    return text


class ReplyReader:
    """Finds replies in what comes, in pieces of any size. ``garbled`` counts those that were damaged."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._began = 0.0
        self.garbled = 0

    def feed(self, data: bytes, now: float) -> list[Reply]:
        """Add ``data``, which came at ``now`` (s); the replies that are whole now, in order."""
        if not self._buffer:
            self._began = now
        self._buffer += data
        replies: list[Reply] = []
        while (end := self._buffer.find(b"\n\n")) >= 0:
            block = bytes(self._buffer[:end]).lstrip(b"\n")
            del self._buffer[: end + 2]
            if block:
                try:
                    replies.append(parse(block, self._began))
                except Garbled:
                    self.garbled += 1
            self._began = now
        if len(self._buffer) > MOST_BYTES:
            self._buffer.clear()
            self.garbled += 1
        return replies


def table(reply: Reply) -> dict[str, str]:
    """The ``NAME:value;`` lines of a reply to VV, PP or II. Raises Garbled."""
    found: dict[str, str] = {}
    for line in reply.lines:
        match = _VALUE.fullmatch(line.decode("ascii", "replace"))
        if match is None:
            raise Garbled(f"a line of {reply.code} is no NAME:value;")
        found[match[1].strip()] = match[2].strip()
    return found


@dataclass(frozen=True, slots=True)
class LaserGeometry:
    """What PP says of a laser: its ``model``, distances (mm) that it measures, steps in a turn, its ``first``, ``last``
    and ``front`` step (counter-clockwise), and turns a minute."""

    model: str
    least_mm: int
    most_mm: int
    turn: int
    first: int
    last: int
    front: int
    rpm: int

    @property
    def turn_s(self) -> float:
        """Time of a turn, s."""
        return 60.0 / self.rpm

    def within(self, fov_rad: float) -> tuple[int, int]:
        """The first and the last step of a field of view about the front; no more than it sees."""
        half = math.floor(fov_rad / 2 / (2 * math.pi / self.turn) + 1e-6)
        return max(self.first, self.front - half), min(self.last, self.front + half)


def geometry(values: Mapping[str, str]) -> LaserGeometry:
    """The geometry of PP's ``values``. Raises Garbled for one that is missing or impossible."""
    names = ("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN")
    try:
        numbers = [int(values[name]) for name in names]
    except KeyError as missing:
        raise Garbled(f"PP does not say {missing.args[0]}") from None
    except ValueError:
        raise Garbled(f"PP says {', '.join(f'{name}:{values[name]}' for name in names)}: no numbers") from None
    least, most, turn, first, last, front, rpm = numbers
    if not (0 <= least < most and turn > 0 and 0 <= first < last and first <= front <= last and rpm > 0):
        raise Garbled(f"PP says impossible sizes: {', '.join(f'{name}:{values[name]}' for name in names)}")
    return LaserGeometry(values.get("MODL", "Hokuyo"), least, most, turn, first=first, last=last, front=front, rpm=rpm)


@dataclass(frozen=True, slots=True)
class Measurement:
    """A scan as the laser gives it: ``milliseconds`` of its own clock (24 bits), distances (N,) in mm and intensities
    (N,), which are 0 where it was not asked for them."""

    milliseconds: int
    distances: NDArray[np.int64]
    intensities: NDArray[np.int64]


def scan_command(first: int, last: int, *, characters: int = 3, intensities: bool = False, single: bool = False) -> str:
    """The command for scans without end, or for a ``single`` one, in 2 or 3 ``characters`` a distance.

    Intensities come with 3 characters alone. Raises ValueError for another request.
    """
    if characters not in (2, 3) or (intensities and characters != 3):
        raise ValueError("distances have 2 or 3 characters, and 3 beside intensities")
    kind = "E" if intensities else "D" if characters == 3 else "S"
    return f"{'G' if single else 'M'}{kind}{first:04d}{last:04d}01" + ("" if single else "000")


def measurement(reply: Reply) -> Measurement:
    """The scan in a reply to MD, MS, ME, GD, GS or GE. Raises Garbled where it is not as long as was asked for."""
    if len(reply.lines) < 2:
        raise Garbled("a scan without data")
    stamp = decode(reply.lines[0], 4)
    data = b"".join(reply.lines[1:])
    asked = int(reply.command[6:10]) - int(reply.command[2:6]) + 1 if reply.command[2:10].isdecimal() else -1
    values = decode(data, 2 if reply.code[1] == "S" else 3)
    if reply.code[1] == "E":
        if values.size % 2:
            raise Garbled("a distance without its intensity")
        distances, intensities = values[::2], values[1::2]
    else:
        distances, intensities = values, np.zeros_like(values)
    if stamp.size != 1 or distances.size != asked:
        raise Garbled(f"a scan of {distances.size} distances, where {asked} were asked for")
    return Measurement(int(stamp[0]), distances, intensities)


def reply_bytes(command: str, status: str, lines: list[bytes] | None = None, *, table: bool = False) -> bytes:
    """A reply as a laser sends it; the lines of a ``table`` end in a semicolon."""
    rows = [command.encode(), status.encode() + checksum(status.encode())]
    rows += [line + (b";" if table else b"") + checksum(line) for line in lines or []]
    return b"\n".join(rows) + b"\n\n"


def data_lines(milliseconds: int, data: bytes) -> list[bytes]:
    """The lines of a scan: its time, and its ``data`` in lines of 64 characters."""
    stamp = encode(np.array([milliseconds % 2**24]), 4)
    return [stamp, *(data[start : start + LINE] for start in range(0, len(data), LINE))]
