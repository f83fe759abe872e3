"""What all messages have in common."""

from __future__ import annotations

from typing import Annotated, Any, Protocol, TypeVar

from msgspec import Meta
from numpy.typing import NDArray

ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


def doc(text: str) -> Meta:
    """What a field of a record is, for the descriptions that are made of it: ``Annotated[float, doc("In m.")]``."""
    return Meta(description=text)


Stamp = Annotated[float, Meta(description="Seconds of the robot's clock (Unix epoch).", examples=[1795000000.25])]


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
