"""One connection to the live stream."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.console.drive.command_age import CommandAge
from app.console.live.outbox import Outbox
from app.console.live.protocol import CAMERA


@dataclass(slots=True, eq=False)
class Viewer:
    """One connection: its id ``session``, its operator's name, its outbox, the pictures and sound it subscribes to."""

    session: str
    operator: str
    #: How old its commands are.
    age: CommandAge
    outbox: Outbox = field(default_factory=Outbox)
    #: Kinds of pictures that its page shows.
    shows: set[int] = field(default_factory=lambda: {CAMERA})
    listens: bool = False
    #: The last round trip that the page measured.
    rtt_ms: float | None = None
