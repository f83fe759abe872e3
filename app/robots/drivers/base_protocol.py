"""The serial protocol of a differential base (docs/serial-base.md): pure functions between frames and bytes.

A frame is type, sequence number, payload and CRC-16/CCITT-FALSE (polynomial 0x1021, initial value 0xFFFF), all
little-endian, stuffed by COBS so that 0x00 occurs in none, and ended by 0x00. A reader that begins in the middle, or
lost bytes, is right again at the next 0x00.

Source of COBS: Cheshire, Baker, "Consistent Overhead Byte Stuffing", SIGCOMM 1997.
"""

from __future__ import annotations

import binascii
import struct
from dataclasses import dataclass
from enum import IntFlag
from typing import TypeAlias

VERSION = 1
END = b"\0"
#: A payload has no more bytes than these.
MOST_PAYLOAD = 64
#: Type, sequence, payload and CRC, and COBS's one byte.
MOST_FRAME = MOST_PAYLOAD + 5
_HEAD = struct.Struct("<BB")
_CRC = struct.Struct("<H")


class Garbled(ValueError):
    """Bytes that are no frame of the protocol, or one that was damaged; the message is for people."""


class Fault(IntFlag):
    """What a base says of itself in each STATE; all but SILENT and LOW_BATTERY keep it from driving."""

    SILENT = 1
    EMERGENCY_BUTTON = 2
    LEFT_DRIVE = 4
    RIGHT_DRIVE = 8
    HOT = 16
    LOW_BATTERY = 32
    ENCODER = 64
    BUMPER = 128


STOPPING = ~(Fault.SILENT | Fault.LOW_BATTERY)
WORDS = {
    Fault.EMERGENCY_BUTTON: "its emergency button is pressed",
    Fault.LEFT_DRIVE: "its left drive has failed",
    Fault.RIGHT_DRIVE: "its right drive has failed",
    Fault.HOT: "its drives are too hot",
    Fault.LOW_BATTERY: "its battery is low",
    Fault.ENCODER: "an encoder has failed",
    Fault.BUMPER: "its bumper is pressed",
}


@dataclass(frozen=True, slots=True)
class Hello:
    """To the base: who are you? Answered by Identity."""

    version: int = VERSION


@dataclass(frozen=True, slots=True)
class Velocity:
    """To the base: velocity (mm/s, mrad/s, left positive), valid for ``timeout_ms`` from its arrival; ``brake``: at
    once, as hard as the drives can, in place of the base's own ramp."""

    linear_mmps: int
    angular_mradps: int
    timeout_ms: int
    brake: bool = False


@dataclass(frozen=True, slots=True)
class Identity:
    """From the base, when it begins and for each Hello: ``boot`` is another after each restart; greatest speeds (mm/s,
    mrad/s); encoder counts of a metre of a wheel's way; track (um); a name (UTF-8)."""

    version: int
    boot: int
    linear_mmps: int
    angular_mradps: int
    ticks_per_m: int
    track_um: int
    name: str


@dataclass(frozen=True, slots=True)
class State:
    """From the base, 20 to 200 times a second: its clock (us, 32 bits), the counts of both wheels since it began (32
    bits, signed, running over), the sequence number of the newest Velocity, and its faults."""

    time_us: int
    left: int
    right: int
    taken: int
    faults: Fault


@dataclass(frozen=True, slots=True)
class Battery:
    """From the base, about once a second: mV, mA (into it), charge (per cent, None where it is not known)."""

    millivolts: int
    milliamperes: int
    percent: int | None
    charging: bool


@dataclass(frozen=True, slots=True)
class Text:
    """From the base: a sentence for people, for the log."""

    text: str


Frame: TypeAlias = Hello | Velocity | Identity | State | Battery | Text

_FORMATS: dict[int, struct.Struct] = {
    0x01: struct.Struct("<B"),
    0x02: struct.Struct("<hhHB"),
    0x81: struct.Struct("<BHHHII"),
    0x82: struct.Struct("<IiiBH"),
    0x83: struct.Struct("<HhBB"),
    0x84: struct.Struct("<"),
}
_UNKNOWN_CHARGE = 255


def crc(data: bytes) -> int:
    """CRC-16/CCITT-FALSE."""
    return binascii.crc_hqx(data, 0xFFFF)


def stuffed(data: bytes) -> bytes:
    """``data`` without 0x00, by COBS."""
    found = bytearray()
    for part in data.split(END):
        while len(part) >= 254:
            found += b"\xff" + part[:254]
            part = part[254:]
        found += bytes((len(part) + 1,)) + part
    return bytes(found)


def unstuffed(data: bytes) -> bytes:
    """The inverse of :func:`stuffed`. Raises Garbled."""
    found = bytearray()
    at = 0
    while at < len(data):
        code = data[at]
        part = data[at + 1 : at + code]
        if code == 0 or len(part) != code - 1 or 0 in part:
            raise Garbled("a frame is cut off")
        found += part
        at += code
        if code < 255 and at < len(data):
            found += END
    return bytes(found)


def encode(frame: Frame, sequence: int) -> bytes:
    """``frame`` as it goes over the line, 0x00 at its end."""
    match frame:
        case Hello(version):
            kind, payload = 0x01, _FORMATS[0x01].pack(version)
        case Velocity(linear, angular, timeout, brake):
            kind, payload = 0x02, _FORMATS[0x02].pack(linear, angular, timeout, brake)
        case Identity(version, boot, linear, angular, ticks, track, name):
            kind, payload = 0x81, _FORMATS[0x81].pack(version, boot, linear, angular, ticks, track) + name.encode()
        case State(time_us, left, right, taken, faults):
            kind, payload = 0x82, _FORMATS[0x82].pack(time_us, left, right, taken, int(faults))
        case Battery(millivolts, milliamperes, percent, charging):
            share = _UNKNOWN_CHARGE if percent is None else percent
            kind, payload = 0x83, _FORMATS[0x83].pack(millivolts, milliamperes, share, charging)
        case Text(text):
            kind, payload = 0x84, text.encode()
    whole = _HEAD.pack(kind, sequence % 256) + payload[:MOST_PAYLOAD]
    return stuffed(whole + _CRC.pack(crc(whole))) + END


def decode(data: bytes) -> tuple[Frame, int]:
    """The frame in ``data``, which is without the 0x00 at its end, and its sequence number. Raises Garbled."""
    whole = unstuffed(data)
    if len(whole) < _HEAD.size + _CRC.size:
        raise Garbled("a frame is too short")
    body = whole[: -_CRC.size]
    if crc(body) != _CRC.unpack(whole[-_CRC.size :])[0]:
        raise Garbled("the CRC of a frame is wrong")
    kind, sequence = _HEAD.unpack_from(body)
    layout = _FORMATS.get(kind)
    if layout is None:
        raise Garbled(f"there is no frame of type 0x{kind:02x}")
    payload = body[_HEAD.size :]
    rest = payload[layout.size :]
    if len(payload) < layout.size or len(payload) > MOST_PAYLOAD or (rest and kind not in (0x81, 0x84)):
        raise Garbled(f"a frame of type 0x{kind:02x} has {len(payload)} bytes; it should have {layout.size}")
    return _frame(kind, layout.unpack_from(payload), rest.decode("utf-8", "replace")), sequence


def _frame(kind: int, values: tuple[int, ...], text: str) -> Frame:
    match kind:
        case 0x01:
            return Hello(*values)
        case 0x02:
            linear, angular, timeout_ms, flags = values
            return Velocity(linear, angular, timeout_ms, brake=bool(flags & 1))
        case 0x81:
            version, boot, linear, angular, ticks, track = values
            return Identity(version, boot, linear, angular, ticks_per_m=ticks, track_um=track, name=text)
        case 0x82:
            time_us, left, right, taken, faults = values
            return State(time_us, left, right, taken, Fault(faults & sum(Fault)))
        case 0x83:
            charge = None if values[2] == _UNKNOWN_CHARGE else min(values[2], 100)
            return Battery(values[0], values[1], charge, charging=bool(values[3]))
        case _:
            return Text(text)


class FrameReader:
    """Finds frames in what comes, in pieces of any size. ``garbled`` counts those that were damaged."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._skipping = False
        self.garbled = 0

    def feed(self, data: bytes) -> list[tuple[Frame, int]]:
        """Add ``data``; the frames that are whole now, in order, and their sequence numbers."""
        frames: list[tuple[Frame, int]] = []
        self._buffer += data
        *whole, rest = self._buffer.split(END)
        self._buffer = rest
        for part in whole:
            if self._skipping:
                self._skipping = False
            elif part:
                try:
                    frames.append(decode(bytes(part)))
                except Garbled:
                    self.garbled += 1
        if len(self._buffer) > MOST_FRAME:
            # No frame is so long: what comes until the next end belongs to this one.
            self._buffer.clear()
            self.garbled += not self._skipping
            self._skipping = True
        return frames
