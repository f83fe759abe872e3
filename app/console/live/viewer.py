"""One connection to the live stream."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.console.access.identity import LOCAL, Identity
from app.console.drive.command_age import CommandAge
from app.console.live.outbox import Outbox
from app.console.live.picture_budget import Form, PictureBudget, drawn, round_trip
from app.console.live.protocol import CAMERA, PANORAMA


@dataclass(slots=True, eq=False)
class Viewer:
    """One connection: its id ``session``, its operator's name, its outbox, the pictures and sound it subscribes to.

    ``identity`` is the login that it belongs to.
    """

    session: str
    operator: str
    #: How old its commands are.
    age: CommandAge
    identity: Identity = LOCAL
    outbox: Outbox = field(default_factory=Outbox)
    #: Kinds of pictures that its page shows.
    shows: set[int] = field(default_factory=lambda: {CAMERA})
    listens: bool = False
    #: Kinds of messages that it was refused for its role, with a notice, and goes on sending.
    refused: set[str] = field(default_factory=set)
    #: The last round trip that the page measured.
    rtt_ms: float | None = None
    #: Its page decodes VP9.
    vp9: bool = False
    #: By kind of picture: how many px wide the page shows it, what the viewer bears, and the newest that it was given.
    widths: dict[int, int] = field(default_factory=dict)
    budgets: dict[int, PictureBudget] = field(
        default_factory=lambda: dict.fromkeys((CAMERA, PANORAMA), PictureBudget())
    )
    given: dict[int, int] = field(default_factory=dict)

    def form(self, kind: int, source: int, *, video: bool = True) -> Form:
        """The form of its pictures of ``kind``, which come ``source`` px wide; ``video``: it may be that."""
        return self.budgets[kind].form(source, self.widths.get(kind), vp9=video and self.decodes(kind))

    def decodes(self, kind: int) -> bool:
        """Whether its page decodes pictures of ``kind`` as VP9: of the camera's, which its worker draws."""
        return self.vp9 and kind == CAMERA

    def round_trip(self, now: float) -> None:
        """The page has measured ``rtt_ms``."""
        if self.rtt_ms is not None:
            for kind, budget in self.budgets.items():
                self.budgets[kind] = round_trip(budget, 1e-3 * self.rtt_ms, now)

    def drawn(self, kind: int, now: float) -> None:
        """The page has drawn a picture of ``kind``; ``now`` by the loop's clock."""
        taken = self.outbox.picture_drawn(kind)
        if taken is not None and kind in self.budgets:
            self.budgets[kind] = budget = drawn(self.budgets[kind], now - taken, now, vp9=self.decodes(kind))
            self.outbox.most_under_way[kind] = budget.most_under_way
