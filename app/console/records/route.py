"""Ways on the map in use that are planned and not driven."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from app.maps.route_service import LegState
from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class RouteLegReport:
    """A way from one point of a route to the next."""

    state: Annotated[
        LegState,
        doc("`way`: it leads there. `near`: to the nearest place that can be reached. `none`: it cannot be driven."),
    ]
    reason: Annotated[str, doc("Why it does not lead there, or what is special about it, in words; empty: nothing.")]
    length_m: float
    duration_s: Annotated[float, doc("About how long it takes if nothing is in the way, with turns on the spot.")]
    path: Annotated[tuple[tuple[float, float], ...], doc("Its corners x, y on the map (m), at most 200.")]


@dataclass(frozen=True, slots=True)
class RouteReport:
    """A route, leg by leg."""

    map: Annotated[str, doc("The map in use; empty: it has no name yet.")]
    legs: Annotated[tuple[RouteLegReport, ...], doc("One less than points.")]
    length_m: Annotated[float, doc("Of all legs that can be driven.")]
    duration_s: Annotated[float, doc("Of all legs that can be driven.")]
