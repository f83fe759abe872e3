"""What is at a port: a machine of bytes and values, without port and clock, so that a test can step it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeAlias

Reading: TypeAlias = tuple[str, object]
"""A stream, and a message of it."""

#: How much of what a wrong device said is repeated.
_SHOWN = 32


class WrongDevice(Exception):
    """What answers at a port is another device than the body's file says; the message is for people."""


class DeviceLost(Exception):
    """The device does not answer any more, or began again: its port has to be opened again. For people."""


class Device(Protocol):
    """A device; all times are of the robot's clock (s).

    ``name`` in messages for people; ``cautions`` are sentences for the log; ``ready``: it has answered as the device
    that it should be.
    """

    name: str
    cautions: list[str]

    @property
    def ready(self) -> bool: ...

    def opened(self, now: float) -> None:
        """Its port has opened: begin."""
        ...

    def closed(self, now: float) -> Iterable[Reading]:
        """Its port is lost; what that says to others."""
        ...

    def received(self, data: bytes, now: float) -> Iterable[Reading]:
        """Bytes have come; the messages in them. Raises WrongDevice, DeviceLost."""
        ...

    def step(self, now: float) -> tuple[bytes, Iterable[Reading]]:
        """Called many times a second while its port is open: what is to be sent, and what is to be said. Raises
        WrongDevice, DeviceLost."""
        ...

    def problem(self, now: float) -> str:
        """Why the robot must not drive, by what this device knows; "" if it may."""
        ...


def shown(data: bytes) -> str:
    """What a device said, for people."""
    if not data:
        return "it said nothing"
    return f"it said {data[:_SHOWN]!r}" + (" ..." if len(data) > _SHOWN else "")
