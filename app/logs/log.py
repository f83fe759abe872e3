"""A log for its readers, in any format: messages by channel in the order they arrived."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from app.logs.manifest import Manifest


class LogError(Exception):
    """A log that cannot be read or written; the message names the file and says what to do."""


@dataclass(frozen=True, slots=True)
class Logged:
    """One message of a log: it arrived on ``channel`` at ``at`` (robot's clock, s); its ``stamp`` is its capture."""

    at: float
    channel: str
    message: Any


@dataclass(frozen=True, slots=True)
class LoggedChannel:
    """A channel of a log: the class of its messages (of ``app.messages``) and how many there are."""

    name: str
    message_type: type[Any]
    count: int
    #: The value in the channel table at the time of recording; None if unknown.
    rate_hz: float | None = None


@dataclass(frozen=True, slots=True)
class LogInfo:
    """Facts of a log. ``begin`` and ``end`` (robot's clock, s) of its first and last message, equal if it is empty.

    ``format`` is its name for people (``HBBA MCAP``, ``ROS 1 bag``, ``ROS 2 bag``, ``CARMEN``). ``ignored`` names
    topics for which this program has no message, and why; ``notes`` are assumptions of the reader. ``timed`` is False
    if the times of messages are assumed, too.
    """

    path: Path
    format: str
    begin: float
    end: float
    channels: Mapping[str, LoggedChannel]
    bytes: int
    ignored: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    timed: bool = True

    @property
    def duration_s(self) -> float:
        """Seconds from the first message to the last."""
        return self.end - self.begin


class Log(Protocol):
    """A log opened for reading. Not for use from several threads at once; :meth:`close` it."""

    @property
    def info(self) -> LogInfo:
        """Its facts; read from the summary, not by going through the messages, where the format has one."""
        ...

    @property
    def manifest(self) -> Manifest:
        """The files and facts attached to it; empty for a log that another program wrote."""
        ...

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        """Messages that arrived at ``begin`` or later, of these channels (None: all), in order of arrival.

        Decoded one by one as they are asked for. Raises LogError where the file is damaged.
        """
        ...

    def close(self) -> None:
        """Release the file."""
        ...
