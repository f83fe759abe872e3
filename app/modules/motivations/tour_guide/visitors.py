"""Visitors: who is seen and heard around the robot, and which way to turn to them. No clock, no channels.

People are counted and forgotten; no identity and no picture is kept.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from app.base.geometry import Pose2, wrap_angle
from app.messages import Person, Persons

Point = tuple[float, float]

#: A person is there for so long (s) after the last sighting.
SEEN_S: Final = 2.5
#: A voice says where people are for so long (s), and somebody speaks for so long after it.
HEARD_S: Final = 5.0
SPEAKS_S: Final = 1.0
#: Who was seen since the robot looks for visitors is remembered for so long (s).
FOUND_S: Final = 20.0
#: A face that appears is that of a person who was out of sight for this long (s), and at most so far away (m, and m/s
#: since then).
_HIDDEN_S, _SAME_M, _SAME_MPS, _SAME_MOST_M = 0.5, 0.5, 1.0, 1.5
#: What is bound into persons says who is there for so long (s).
_BOUND_S: Final = 1.0
#: Legs that were never seen to walk count once they stood so long (s), this far (m) from anybody else.
STOOD_S, _ALONE_M = 1.0, 0.6
#: The last sighting says where people are until the robot has driven so far (m).
_STILL_THERE_M: Final = 1.0
#: The way that was driven is kept by points this far apart (m), so many of them.
_STEP_M, _POINTS = 0.25, 60
#: Along that way it looks at least and at most so far (m), and only as far as it was driven straight to within (m):
#: farther, it would look past the corner of a door.
_LOOKS_M, _STRAIGHT_M = (0.7, 4.5), 0.4
#: It drives back no less and no farther than this (m).
_BACK_M = (0.7, 8.0)


@dataclass(frozen=True, slots=True)
class People:
    """Who is around: how many, the distance of the farthest and the nearest (m), how many are near; whether one speaks;
    the heading towards them, or where they are looked for (rad in odom; None while unknown). ``found``,
    ``found_m``: the same of those who were seen since they are looked for; ``others``, ``others_m``,
    ``others_nearest_m``: the same of persons whose face is not seen; ``behind``: the heading along the way that the
    robot came."""

    people: int = 0
    farthest_m: float = 0.0
    nearest_m: float = 0.0
    near: int = 0
    speaking: bool = False
    towards: float | None = None
    found: int = 0
    found_m: float = 0.0
    others: int = 0
    others_m: float = 0.0
    others_nearest_m: float = 0.0
    behind: float | None = None


class Visitors:
    """What was seen and heard of people; places are x, y (m) in odom, times those of the robot's clock (s)."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[float, Point]] = {}
        #: What was bound last, and since when (s) the tracks in it are there.
        self._persons = Persons(-math.inf, ())
        self._since: dict[int, float] = {}
        #: Points of the way with what was driven until there.
        self._trail: deque[tuple[float, Point]] = deque(maxlen=_POINTS)
        #: Whether the robot drives back along its way, which ends where it is then.
        self.returns = False
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
        if self.returns:
            while len(self._trail) > 1 and math.dist(self._trail[-2][1], place) <= math.dist(self._trail[-1][1], place):
                self._trail.pop()
        elif not self._trail or math.dist(self._trail[-1][1], place) >= _STEP_M:
            self._trail.append((self.driven_m, place))

    @property
    def astray_m(self) -> float:
        """How far (m) from the way that it came the robot is while it drives back; 0.0 else."""
        if not self.returns or self._place is None:
            return 0.0
        return min((math.dist(self._place, point) for _, point in self._trail), default=0.0)

    def see(self, stamp: float, places: Mapping[int, Point]) -> None:
        """Faces by track, seen at ``stamp``."""
        for track, place in places.items():
            if track not in self._seen and (former := self._former(stamp, place, places)) is not None:
                del self._seen[former]
            self._seen[track] = stamp, place

    def bind(self, persons: Persons) -> None:
        """Who is there, with a face or without."""
        self._persons = persons
        self._since = {each.track: self._since.get(each.track, persons.stamp) for each in persons.persons}

    def hear(self, stamp: float, heading: float) -> None:
        """A voice came from ``heading`` (rad) at ``stamp``."""
        self._voice = stamp, heading

    def _former(self, stamp: float, place: Point, others: Mapping[int, Point]) -> int | None:
        """The track of the person who appears at ``place`` as another, having been out of sight."""
        hidden = [
            (math.dist(place, before), track)
            for track, (seen, before) in self._seen.items()
            if track not in others
            and stamp - seen >= _HIDDEN_S
            and math.dist(place, before) <= min(_SAME_M + _SAME_MPS * (stamp - seen), _SAME_MOST_M)
        ]
        return min(hidden)[1] if hidden else None

    def back(self, seen_m: float) -> Point | None:
        """Where the robot was when it had driven ``seen_m`` (m); None where that is here, or not known any more."""
        if self._place is None:
            return None
        point = next((point for driven_m, point in self._trail if driven_m >= seen_m - _STEP_M), None)
        if point is None or not _BACK_M[0] <= math.dist(point, self._place):
            return None
        near = (p for driven_m, p in self._trail if driven_m >= max(seen_m - _STEP_M, self.driven_m - _BACK_M[1]))
        return next(near, None)

    def around(
        self,
        now: float,
        X_OB: Pose2,
        *,
        within_m: float,
        behind: bool,
        sought_since: float | None = None,
        legs_m: float = 0.0,
    ) -> People:
        """Who is there at ``now``. ``behind``: only those who are behind the robot follow it, none ahead does;
        ``sought_since``: since when (s) they are looked for, None while they are not; ``legs_m``: so far (m), legs that
        were never seen to walk are somebody's."""
        self._seen = {track: seen for track, seen in self._seen.items() if now - seen[0] <= FOUND_S}
        here = (X_OB.x, X_OB.y)
        places = [place for stamp, place in self._seen.values() if now - stamp <= SEEN_S]
        since = math.inf if sought_since is None else sought_since
        found = [math.dist(here, place) for stamp, place in self._seen.values() if stamp >= since]
        others = [] if behind else [math.dist(here, place) for place in self._faceless(now, here, since, legs_m)]
        if behind:
            places = [p for p in places if abs(wrap_angle(_heading(here, p) - X_OB.theta)) > math.pi / 2]
        speaking = self._voice is not None and now - self._voice[0] <= SPEAKS_S
        distances = [math.dist(here, place) for place in places]
        if places:
            middle = (sum(x for x, _ in places) / len(places), sum(y for _, y in places) / len(places))
            self._last_seen = middle, self.driven_m
        return People(
            people=len(places),
            farthest_m=max(distances, default=0.0),
            nearest_m=min(distances, default=0.0),
            near=sum(distance <= within_m for distance in distances),
            speaking=speaking,
            towards=self._towards(now, here, bool(places)),
            found=len(found),
            found_m=max(found, default=0.0),
            others=len(others),
            others_m=max(others, default=0.0),
            others_nearest_m=min(others, default=0.0),
            behind=self._behind(here),
        )

    def _faceless(self, now: float, here: Point, sought_since: float, legs_m: float) -> list[Point]:
        """Where persons are whose face was not seen lately, nor since they are looked for."""
        if now - self._persons.stamp > _BOUND_S:
            return []
        least = min(sought_since, now - SEEN_S)
        faces = {track: seen for track, seen in self._seen.items() if seen[0] >= least}
        believed = [each for each in self._persons.persons if each.state != "tentative" and each.last_seen >= least]
        places = _without_face(now, faces, believed)
        taken = [*(place for _, place in faces.values()), *places]
        for each in self._persons.persons:
            place = each.p_OP[:2]
            stood = each.state == "tentative" and now - self._since[each.track] >= STOOD_S
            if stood and math.dist(here, place) <= legs_m and all(math.dist(place, o) > _ALONE_M for o in taken):
                taken.append(place)
                places.append(place)
        return places

    def _towards(self, now: float, here: Point, seen: bool) -> float | None:
        last = self._last_seen
        if seen and last is not None:
            return _heading(here, last[0])
        if self._voice is not None and now - self._voice[0] <= HEARD_S:
            return self._voice[1]
        if last is not None and self.driven_m - last[1] <= _STILL_THERE_M:
            return _heading(here, last[0])
        behind = self._behind(here)
        return _heading(here, last[0]) if behind is None and last is not None else behind

    def _behind(self, here: Point) -> float | None:
        """The heading along the way that was driven, to where it turns aside; None where it has only started."""
        seen: Point | None = None
        passed: list[Point] = []
        for _, point in reversed(self._trail):
            away_m = math.dist(here, point)
            if away_m > _LOOKS_M[1] or any(_beside(here, point, each) > _STRAIGHT_M for each in passed):
                break
            passed.append(point)
            if away_m >= _LOOKS_M[0]:
                seen = point
        return None if seen is None else _heading(here, seen)


def _without_face(now: float, faces: Mapping[int, tuple[float, Point]], persons: Sequence[Person]) -> list[Point]:
    """Where those of ``persons`` are who have none of ``faces`` (time and place by track); each is the nearest's."""
    pairs = sorted(
        (math.dist(each.p_OP[:2], place), track, each.track)
        for track, (seen, place) in faces.items()
        for each in persons
        if math.dist(each.p_OP[:2], place) <= min(_SAME_M + _SAME_MPS * max(now - seen, 0.0), _SAME_MOST_M)
    )
    used: set[int] = set()
    having: set[int] = set()
    for _, face, person in pairs:
        if face not in used and person not in having:
            used.add(face)
            having.add(person)
    return [each.p_OP[:2] for each in persons if each.track not in having]


def _heading(here: Point, there: Point) -> float:
    return math.atan2(there[1] - here[1], there[0] - here[0])


def _beside(begin: Point, end: Point, point: Point) -> float:
    """The distance (m) of ``point`` from the straight line between the others."""
    x, y = end[0] - begin[0], end[1] - begin[1]
    length = math.hypot(x, y)
    if length == 0.0:
        return math.dist(begin, point)
    along = min(max(((point[0] - begin[0]) * x + (point[1] - begin[1]) * y) / length**2, 0.0), 1.0)
    return math.dist((begin[0] + along * x, begin[1] + along * y), point)
