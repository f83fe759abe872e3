"""A sweep of the gaze: directions that are looked into one after the other, with a pause at each. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: Bearing (left positive) and elevation (up positive), rad, in the axes of ``base_link``.
Direction = tuple[float, float]


def directions(width_rad: float, step_rad: float, elevations: Sequence[float]) -> tuple[Direction, ...]:
    """Directions over ``width_rad`` about straight ahead, at most ``step_rad`` apart, row by row of ``elevations``
    (rad), each row back the other way. The first row begins at the right."""
    count = math.floor(width_rad / step_rad + 1 - 1e-9) + 1 if width_rad > 0 else 1
    bearings = [0.0] if count == 1 else [width_rad * (i / (count - 1) - 0.5) for i in range(count)]
    rows = (bearings if number % 2 == 0 else bearings[::-1] for number in range(len(elevations)))
    return tuple((bearing, elevation) for elevation, row in zip(elevations, rows, strict=True) for bearing in row)


@dataclass(slots=True)
class Sweep:
    """Progress of a sweep: stop ``number`` of ``stops``, in ``round``; ``since`` when it was reached (s), None before
    that."""

    stops: tuple[Direction, ...]
    pause_s: float
    number: int = 0
    round: int = 0
    since: float | None = None

    def step(self, now: float, reached: bool) -> Direction:
        """The direction to look into at ``now`` (s). ``reached``: the gaze is at the last direction given."""
        if self.since is None and reached:
            self.since = now
        if self.since is not None and now - self.since >= self.pause_s:
            self.since = None
            self.number += 1
            if self.number == len(self.stops):
                self.number, self.round = 0, self.round + 1
        return self.stops[self.number]
