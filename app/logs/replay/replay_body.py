"""The body of a recording, as playback needs it."""

from __future__ import annotations

from collections.abc import Callable, Set
from typing import Any, Protocol

from app.link import RobotLink
from app.logs.mcap.damage import LogDamaged


class ReplayBody(RobotLink, Protocol):
    """A body that plays a recording (``app.robots.replayed``), driven by the clock."""

    def seek(self, position: float) -> None:
        """Continue with the first message that arrived after ``position`` (robot's clock, s); emits nothing by itself.

        The clock is paused and has been moved to ``position``.
        """
        ...

    def show(self, channel: str, message: Any) -> None:
        """Deliver ``message``, recorded on ``channel``, now to the receivers of that channel's stream.

        Channels that are no stream of the body are ignored.
        """
        ...

    #: Called when the clock comes to a part of the recording that cannot be read; it goes on behind that.
    on_damage: Callable[[LogDamaged], None]
    #: Whether the body goes on without messages, to the end or to a seek, after damage that cannot be skipped.
    survives: bool
    #: Parts of the log that could not be read so far.
    damages: list[LogDamaged]

    #: Called with True when it must wait for the file, with False when it goes on: time waits with it.
    on_waiting: Callable[[bool], None]

    @property
    def listened(self) -> Set[str]:
        """The channels of the log with an open subscription."""
        ...

    @property
    def reading(self) -> bool:
        """Whether the next message is still being read: the clock must not be moved on meanwhile.

        False once it sleeps on the clock until that message's time, and at the recording's end.
        """
        ...
