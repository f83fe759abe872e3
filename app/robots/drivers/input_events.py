"""Linux input events as they are read from ``/dev/input``: pure functions between bytes and values.

Source: the kernel's documentation (input/event-codes.rst) and ``linux/input-event-codes.h``.
"""

from __future__ import annotations

import fcntl
import struct
from dataclasses import dataclass

#: ``struct input_event``: seconds and microseconds (two longs), type, code, value.
EVENT = struct.Struct("@llHHi")
SYN, KEY, ABS = 0x00, 0x01, 0x03
#: Codes of SYN: events since the last one belong together; some were lost.
REPORT, DROPPED = 0, 3

BUTTONS = {
    "BTN_SOUTH": 0x130, "BTN_EAST": 0x131, "BTN_NORTH": 0x133, "BTN_WEST": 0x134, "BTN_TL": 0x136, "BTN_TR": 0x137,
    "BTN_TL2": 0x138, "BTN_TR2": 0x139, "BTN_SELECT": 0x13A, "BTN_START": 0x13B, "BTN_MODE": 0x13C,
    "BTN_THUMBL": 0x13D, "BTN_THUMBR": 0x13E, "BTN_TRIGGER": 0x120, "BTN_THUMB": 0x121, "BTN_THUMB2": 0x122,
    "BTN_TOP": 0x123, "BTN_TOP2": 0x124, "BTN_PINKIE": 0x125, "BTN_BASE": 0x126, "BTN_BASE2": 0x127,
}  # fmt: skip
AXES = {
    "ABS_X": 0x00, "ABS_Y": 0x01, "ABS_Z": 0x02, "ABS_RX": 0x03, "ABS_RY": 0x04, "ABS_RZ": 0x05, "ABS_THROTTLE": 0x06,
    "ABS_RUDDER": 0x07, "ABS_HAT0X": 0x10, "ABS_HAT0Y": 0x11,
}  # fmt: skip
#: Of an axis whose device does not say: that of most sticks.
USUAL_RANGE = (-32768, 32767)


@dataclass(frozen=True, slots=True)
class InputEvent:
    """One event: ``type`` (SYN, KEY, ABS, ...), ``code`` and ``value``."""

    type: int
    code: int
    value: int


class EventReader:
    """Finds events in what is read, in pieces of any size."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[InputEvent]:
        """Add ``data``; the events that are whole now."""
        self._buffer += data
        whole = len(self._buffer) - len(self._buffer) % EVENT.size
        events = [InputEvent(*fields[2:]) for fields in EVENT.iter_unpack(self._buffer[:whole])]
        self._buffer = self._buffer[whole:]
        return events


def encode(event: InputEvent, seconds: int = 0) -> bytes:
    """``event`` as the kernel gives it."""
    return EVENT.pack(seconds, 0, event.type, event.code, event.value)


def axis_range(descriptor: int, code: int) -> tuple[int, int]:
    """The least and the greatest value of an axis, as its device says (EVIOCGABS); :data:`USUAL_RANGE` where it does
    not."""
    info = struct.Struct("6i")
    request = 2 << 30 | info.size << 16 | ord("E") << 8 | (0x40 + code)
    try:
        _, least, most, *_ = info.unpack(fcntl.ioctl(descriptor, request, bytes(info.size)))
    except OSError:
        return USUAL_RANGE
    return (least, most) if least < most else USUAL_RANGE
