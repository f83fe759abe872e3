"""Records of a log, and the interface of the converters that make them of messages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol


@dataclass(frozen=True, slots=True)
class Record:
    """One ROS message: ``topic``, ``type`` (``sensor_msgs/msg/Image``), capture ``stamp_ns``, little-endian CDR."""

    topic: str
    type: str
    stamp_ns: int
    data: bytes


#: Name of the part that has one record for every message, written after the others.
MAIN = ""


@dataclass(frozen=True, slots=True)
class RecordTopic:
    """A topic that a channel's messages are written to.

    ``part`` names what of the message it carries: :data:`MAIN`, or any other name; None where it is only drawn from
    the message, for programs that show it, and not read back.
    """

    name: str
    type: str
    part: str | None = MAIN


class Converter(Protocol):
    """Converts the messages of one channel and class to records and back. For one thread; it may remember its last
    records."""

    @property
    def topics(self) -> tuple[RecordTopic, ...]:
        """Every topic it writes to; exactly one of them is the main part."""
        ...

    def encode(self, message: Any, stamp_ns: int) -> list[Record]:
        """The records of ``message``, whose stamp is ``stamp_ns``; the main one after its other parts."""
        ...

    def decode(self, parts: Mapping[str, bytes]) -> Any | None:
        """The message of ``parts``, CDR by part; None where a part is missing.

        Raises ValueError for invalid bytes.
        """
        ...
