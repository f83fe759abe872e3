"""In which zones of the map the robot is, and at which places: with hysteresis, as events. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.attention.rule_book import RobotEvent
from app.messages import Place, Zone

#: A zone is left this far (m) beyond its border: SLAM's pose moves by some centimetres.
ZONE_MARGIN_M = 0.1
#: A place is reached within this distance (m), and left beyond the other.
REACHED_M, LEFT_M = 0.5, 0.8


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """Names of the ``zones`` that the robot is in, ids of the ``places`` that it is at."""

    zones: frozenset[str] = frozenset()
    places: frozenset[str] = frozenset()

    def moved(
        self, stamp: float, x: float, y: float, zones: Iterable[Zone], places: Iterable[Place]
    ) -> tuple[Whereabouts, tuple[RobotEvent, ...]]:
        """Where it is at ``x``, ``y`` (m on the map), and what that changes: what is left, then what is entered.

        ``subject`` of an event is a zone's name or a place's id.
        """
        inside = frozenset(
            zone.name
            for zone in zones
            if distance_outside_m(zone.polygon, x, y) <= (ZONE_MARGIN_M if zone.name in self.zones else 0.0)
        )
        there = frozenset(
            place.id
            for place in places
            if math.hypot(place.x - x, place.y - y) <= (LEFT_M if place.id in self.places else REACHED_M)
        )
        events = [
            RobotEvent(stamp, name, subject)
            for name, subjects in (
                ("zone.leaves", self.zones - inside),
                ("place.left", self.places - there),
                ("zone.enters", inside - self.zones),
                ("place.reached", there - self.places),
            )
            for subject in sorted(subjects)
        ]
        return Whereabouts(inside, there), tuple(events)


def distance_outside_m(polygon: NDArray[np.float64], x: float, y: float) -> float:
    """Distance (m) from a point to a ``polygon`` (N, 2; m); 0 inside."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    above = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(above, b[:, 1] - a[:, 1], 1.0)
    crossings = above & (x < a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise)
    if np.count_nonzero(crossings) % 2:
        return 0.0
    along, offset = b - a, np.array([x, y]) - a
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip((along * offset).sum(axis=1) / length, 0.0, 1.0)
    return float(np.hypot(*(offset - share[:, None] * along).T).min())
