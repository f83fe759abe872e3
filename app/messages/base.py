"""What all messages have in common."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Annotated, Any, Protocol, TypeVar

from msgspec import Meta, Struct
from numpy.typing import NDArray

ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


def doc(text: str, *, nullable: bool = False) -> Meta:
    """What a field of a record is, for the descriptions that are made of it: ``Annotated[float, doc("In m.")]``.

    ``nullable``: a float that may be NaN or infinite, which JSON has as null; ``text`` says what that means.
    """
    return Meta(description=text, extra_json_schema={"nullable": True} if nullable else None)


Stamp = Annotated[float, Meta(description="Seconds of the robot's clock (Unix epoch).", examples=[1795000000.25])]


class Message(Protocol):
    """What every message has: the time of its capture."""

    @property
    def stamp(self) -> float:
        """Seconds of the robot's clock (Unix epoch) at capture."""
        ...


def is_record(cls: Any) -> bool:
    """Whether ``cls`` declares a record: a dataclass, or a Struct where JSON has a member ``class``."""
    return isinstance(cls, type) and (is_dataclass(cls) or issubclass(cls, Struct))


def field_names(cls: type[Any]) -> tuple[str, ...]:
    """Names of the fields of the record ``cls``, in order."""
    return cls.__struct_fields__ if issubclass(cls, Struct) else tuple(field.name for field in fields(cls))


def read_only(array: ArrayT) -> ArrayT:
    """Clear the write flag of ``array`` and return it, so that delivery by reference stays safe."""
    array.flags.writeable = False
    return array
