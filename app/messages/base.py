"""What all messages have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

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


@dataclass(frozen=True, slots=True)
class PerceptKind:
    """A kind of percept events, declared by the type of the messages that they are made of (:class:`Look`).

    ``name`` begins the events' names (``dark.appears``). ``words``: what people read of a subject that is there,
    ``{subject}`` in it being which.
    """

    name: str
    words: str


class Look(Protocol):
    """A message of which percept events are made as it is: one look of a perception, at nothing too."""

    percept_kind: ClassVar[PerceptKind]

    @property
    def stamp(self) -> float:
        """Seconds of the robot's clock (Unix epoch) at capture."""
        ...

    @property
    def frame(self) -> str:
        """Name of the sensor."""
        ...

    @property
    def subjects(self) -> Mapping[str, float]:
        """Confidence, 0 to 1, in each subject that this look shows; "" where there can be but one."""
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
