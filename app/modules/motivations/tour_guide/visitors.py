"""Visitors: who is seen and heard around the robot, and which way to turn to them. No clock, no channels.

People are counted and forgotten; no identity and no picture is kept.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.base.geometry import Pose2, wrap_angle

Point = tuple[float, float]

#: A person is there for so long (s) after the last sighting.
SEEN_S: Final = 2.5
#: A voice says where people are for so long (s), and somebody speaks for so long after it.
HEARD_S: Final = 5.0
SPEAKS_S: Final = 1.0
#: The last sighting says where people are until the robot has driven so far (m).
_STILL_THERE_M: Final = 1.0
#: The way that was driven is kept by points this far apart (m), so many of them; visitors follow at least so far (m)
#: behind.
_STEP_M, _POINTS, _BEHIND_M = 0.25, 20, 1.5


@dataclass(frozen=True, slots=True)
class People:
    """Who is around: how many, the distance of the farthest (m), how many are near; whether one speaks; the heading
    towards them, or where they are looked for (rad in odom; None while unknown)."""

    people: int = 0
    farthest_m: float = 0.0
    near: int = 0
    speaking: bool = False
    towards: float | None = None


class Visitors:
    """What was seen and heard of people; places are x, y (m) in odom, times those of the robot's clock (s)."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[float, Point]] = {}
        self._trail: deque[Point] = deque(maxlen=_POINTS)
        self._last_seen: tuple[Point, float] | None = None
        self._voice: tuple[float, float] | None = None
        #: What the base has driven (m), and where it is.
        self.driven_m = 0.0
        self._place: Point | None = None

    def drive(self, X_OB: Pose2) -> None:
        """The robot is at ``X_OB``."""
        place = (X_OB.x, X_OB.y)
        if self._place is not None:
            self.driven_m += math.dist(self._place, place)
        self._place = place
        if not self._trail or math.dist(self._trail[-1], place) >= _STEP_M:
            self._trail.append(place)

    def see(self, stamp: float, places: Mapping[int, Point]) -> None:
        """Faces by track, seen at ``stamp``."""
        for track, place in places.items():
            self._seen[track] = stamp, place

    def hear(self, stamp: float, heading: float) -> None:
        """A voice came from ``heading`` (rad) at ``stamp``."""
        self._voice = stamp, heading

    def around(self, now: float, X_OB: Pose2, *, within_m: float, behind: bool) -> People:
        """Who is there at ``now``. ``behind``: only those who are behind the robot follow it, none ahead does."""
        self._seen = {track: seen for track, seen in self._seen.items() if now - seen[0] <= SEEN_S}
        here = (X_OB.x, X_OB.y)
        places = [place for _, place in self._seen.values()]
        if behind:
            places = [p for p in places if abs(wrap_angle(_heading(here, p) - X_OB.theta)) > math.pi / 2]
        speaking = self._voice is not None and now - self._voice[0] <= SPEAKS_S
        distances = [math.dist(here, place) for place in places]
        if places:
            middle = (sum(x for x, _ in places) / len(places), sum(y for _, y in places) / len(places))
            self._last_seen = middle, self.driven_m
        return People(
            len(places),
            max(distances, default=0.0),
            sum(distance <= within_m for distance in distances),
            speaking,
            self._towards(now, here, bool(places)),
        )

    def _towards(self, now: float, here: Point, seen: bool) -> float | None:
        last = self._last_seen
        if seen and last is not None:
            return _heading(here, last[0])
        if self._voice is not None and now - self._voice[0] <= HEARD_S:
            return self._voice[1]
        if last is not None and self.driven_m - last[1] <= _STILL_THERE_M:
            return _heading(here, last[0])
        back = next((point for point in reversed(self._trail) if math.dist(point, here) >= _BEHIND_M), None)
        if back is not None:
            return _heading(here, back)
        return None if last is None else _heading(here, last[0])


def _heading(here: Point, there: Point) -> float:
    return math.atan2(there[1] - here[1], there[0] - here[0])
