"""The robots of a fleet, as one console lists them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from app.messages.base import Stamp, doc

FleetState = Literal["well", "stopped", "problem", "refused", "unreachable"]


@dataclass(frozen=True, slots=True)
class FleetRobot:
    """One robot, as its own console answered just now."""

    name: Annotated[str, doc("Its name in the fleet; empty while it has not answered.")]
    body: Annotated[str, doc("What kind of robot it is.")]
    url: Annotated[str, doc("Its own console; empty: this one.")]
    state: Annotated[
        FleetState,
        doc(
            "stopped: its emergency stop is latched; problem: it cannot be driven as it is, or has another's name; "
            "refused: its console asks for another login; unreachable: it does not answer."
        ),
    ]
    detail: Annotated[str, doc("The state in words, where there is more to say.")]
    driver: Annotated[str | None, doc("The operator who drives it.")] = None
    exploited: Annotated[str | None, doc("The behavior that drives its base.")] = None
    charge: Annotated[float | None, doc("Share of its battery's capacity that is left, 0 to 1; null: not known.")] = (
        None
    )
    simulated: bool = False


@dataclass(frozen=True, slots=True)
class FleetReport:
    """This robot first, then the others in the order of the fleet's file."""

    stamp: Stamp
    robots: tuple[FleetRobot, ...]
