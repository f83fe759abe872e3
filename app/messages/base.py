"""What all messages have in common."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

from numpy.typing import NDArray

ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


class Message(Protocol):
    """What every message has: the time of its capture."""

    @property
    def stamp(self) -> float:
        """Seconds of the robot's clock (Unix epoch) at capture."""
        ...


def read_only(array: ArrayT) -> ArrayT:
    """Clear the write flag of ``array`` and return it, so that delivery by reference stays safe."""
    array.flags.writeable = False
    return array
