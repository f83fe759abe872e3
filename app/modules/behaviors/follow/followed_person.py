"""Which of the persons is followed, where they were seen last, and where they are looked for. No clock, no module."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from app.base.geometry import wrap_angle
from app.messages import Person, Persons
from app.modules.behaviors.follow.standing import Point, bearing

#: A person so fast (m/s) walks, and one so fast faces where they go: the place of one at rest drifts by less.
_WALKS_MPS, _FACES_MPS = 0.15, 0.25
#: A face that is seen looks no farther aside (rad) of the robot: beyond, detectors find none.
_FACE_RAD: Final = math.radians(70)
#: Out of sight, they are taken to go on for so long (s).
_GOES_ON_S: Final = 2.0
#: Who appears so near (m) to where a person should be, alone, and is no other known one, is that person.
_SAME_M: Final = 1.0
#: Directions (rad) in which a lost person is looked for, beside the one in which they should be.
_LOOKS: Final = (0.0, math.radians(60), -math.radians(60), math.pi)


@dataclass(frozen=True, slots=True)
class Sight:
    """A person as seen at ``stamp`` (s): place (m) and velocity (m/s) in ``odom``, and whether their face was seen."""

    stamp: float
    at: Point
    v: Point
    face: bool

    def expected(self, now: float) -> Point:
        """Where they should be at ``now``: who walks goes on for a while, and where to after that is not known."""
        walks = math.hypot(*self.v) >= _WALKS_MPS
        ahead = min(max(0.0, now - self.stamp), _GOES_ON_S) if walks else 0.0
        return self.at[0] + ahead * self.v[0], self.at[1] + ahead * self.v[1]


class FollowedPerson:
    """One person among all; ``person``: the number of their identity, None for the nearest when they are first seen."""

    def __init__(self, person: int | None) -> None:
        self.person = person
        #: The newest sight of them; None before the first.
        self.sight: Sight | None = None
        self._track: int | None = None
        self._walked: float | None = None

    @property
    def name(self) -> str:
        """For people."""
        return "the person" if self.person is None else f"Person {self.person}"

    def see(self, persons: Persons, robot: Point, now: float) -> None:
        """Take all ``persons``, with the robot at ``robot`` in ``odom``. A doubtful identity is no reason to leave
        them, nor a reason to take another for them."""
        seen = [person for person in persons.persons if person.state in ("confirmed", "unsure")]
        found = self._found(seen, robot, now)
        if found is None:
            return
        self._track = found.track
        if self.person is None:
            self.person = found.person
        if math.hypot(*found.v_O) >= _FACES_MPS:
            self._walked = math.atan2(found.v_O[1], found.v_O[0])
        stamp = min(found.last_seen, persons.stamp)
        self.sight = Sight(stamp, found.p_OP[:2], found.v_O, found.face is not None)

    def _found(self, seen: Sequence[Person], robot: Point, now: float) -> Person | None:
        known = [person for person in seen if person.person is not None and person.person == self.person]
        if known:
            return known[0]
        # No other known one.
        doubtful = [person for person in seen if person.person is None or self.person is None]
        for person in doubtful:
            if person.track == self._track:
                return person
        if self.sight is not None:
            expected = self.sight.expected(now)
            near = [person for person in doubtful if math.dist(person.p_OP[:2], expected) <= _SAME_M]
            return near[0] if len(near) == 1 else None
        if self.person is None:
            return min(seen, key=lambda person: math.dist(person.p_OP[:2], robot), default=None)
        return None

    def facing(self, robot: Point) -> float:
        """Direction (rad) in which they look: where they walk, or walked last, unless a face is seen that looks
        elsewhere; else it is taken to be towards the robot. Raises ValueError before the first sight."""
        if self.sight is None:
            raise ValueError(f"{self.name} was not seen yet")
        if math.hypot(*self.sight.v) >= _FACES_MPS:
            return math.atan2(self.sight.v[1], self.sight.v[0])
        towards = bearing(self.sight.at, robot)
        if self._walked is None or (self.sight.face and abs(wrap_angle(self._walked - towards)) > _FACE_RAD):
            return towards
        return self._walked


def look_round(towards: float, share: float) -> float:
    """Heading (rad) at ``share``, 0 to 1, of the time for looking round: first ``towards`` (rad), then to both sides,
    last behind."""
    step = min(int(share * len(_LOOKS)), len(_LOOKS) - 1)
    return wrap_angle(towards + _LOOKS[max(0, step)])
