"""A person who follows the robot: along the way that it drove, so much behind, and so much later.

Following the way of another, and not its direction, keeps people out of walls. They stand as soon as they are near
enough, however long the way between is: nobody follows into a dead end that the robot comes back from. They step aside
for a robot that comes towards them, and those whom it asks to let it pass go on along its way until they are behind it.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2

STEP_M = 0.1
"""Distance (m) between two points of the way."""
LOOKAHEAD_M = 0.5
"""People walk towards a point of the way so far (m) ahead of them."""
REJOIN_M = 0.6
"""The newest point of the way that is so near (m) is where a person is on it."""
ASIDE_M, COMING_M = 0.9, 1.5
"""How far (m) from the robot's line a person steps aside, for one that is nearer than this (m) and comes."""
MOVED_S = 1.0
"""A robot that reached a new point of its way within this time (s) is moving."""
LONGEST_M = 200.0
"""Length (m) of the way that is known."""
PASSES_S = 10.0
"""For so long (s) people make room who were asked to."""
DECIDE_S = 0.1
"""Where to walk is decided so often (s)."""


@dataclass(frozen=True, slots=True)
class FollowHabit:
    """How a person follows where a script does not say it: ``distance_m`` behind, ``lag_s`` later."""

    distance_m: float = 1.6
    lag_s: float = 1.0


def draw_habits(rng: np.random.Generator, count: int) -> list[FollowHabit]:
    """``count`` habits: 1.2 to 2.2 m behind, outside of the personal zone, and 0.5 to 1.5 s late."""
    return [FollowHabit(float(rng.uniform(1.2, 2.2)), float(rng.uniform(0.5, 1.5))) for _ in range(count)]


@dataclass(frozen=True, slots=True)
class _Passed:
    """The robot was at ``x``, ``y`` (m) at ``time_s``, ``along_m`` on its way."""

    time_s: float
    x: float
    y: float
    along_m: float


class Follower:
    """Where a person who follows as ``habit`` says walks to. It is to :meth:`see` the robot while they pause, too."""

    def __init__(self, habit: FollowHabit) -> None:
        self.habit = habit
        #: From where the person was on it last.
        self._way: deque[_Passed] = deque(maxlen=round(LONGEST_M / STEP_M))
        self._decided_at = -math.inf
        self._goal: tuple[float, float] | None = None
        self._asked_at = -math.inf

    def let_pass(self, now: float) -> None:
        """The robot asks at ``now`` to be let pass."""
        self._asked_at = now

    def see(self, now: float, X_WB: Pose2) -> None:
        """The robot is at ``X_WB`` at ``now`` (simulated s)."""
        if not self._way:
            self._way.append(_Passed(now, X_WB.x, X_WB.y, 0.0))
            return
        last = self._way[-1]
        gone = math.hypot(X_WB.x - last.x, X_WB.y - last.y)
        if gone >= STEP_M:
            self._way.append(_Passed(now, X_WB.x, X_WB.y, last.along_m + gone))

    def goal(self, now: float, here: tuple[float, float], X_WB: Pose2) -> tuple[float, float] | None:
        """The point to walk to now from ``here`` (m, world) with the robot at ``X_WB``; None to stand."""
        if now - self._decided_at >= DECIDE_S - 1e-9:
            self._decided_at = now
            self._goal = self._aside(now, here, X_WB) or self._along(now, here)
        return self._goal

    def _along(self, now: float, here: tuple[float, float]) -> tuple[float, float] | None:
        seen = list(itertools.takewhile(lambda passed: passed.time_s <= now - self.habit.lag_s, self._way))
        if not seen:
            return None
        away = [math.dist(here, (passed.x, passed.y)) for passed in seen]
        # Where the person was beside the way last, or else the point nearest to it.
        beside = [number for number, distance in enumerate(away) if distance <= REJOIN_M]
        number = beside[-1] if beside else away.index(min(away))
        while beside and number > 0 and away[number - 1] < away[number]:
            number -= 1
        if beside:
            for _ in range(number):
                self._way.popleft()
        if away[-1] <= self.habit.distance_m and not self._makes_room(now):
            return None
        stand_m = min(seen[-1].along_m - self.habit.distance_m, seen[number].along_m + LOOKAHEAD_M)
        ahead = [passed for passed in seen[number:] if passed.along_m <= stand_m]
        if not ahead:
            return None
        target = ahead[-1] if beside else seen[number]
        return target.x, target.y

    def _makes_room(self, now: float) -> bool:
        return self.habit.lag_s <= now - self._asked_at <= PASSES_S + self.habit.lag_s

    def _aside(self, now: float, here: tuple[float, float], X_WB: Pose2) -> tuple[float, float] | None:
        """A place beside the robot's line, where it comes; None where it does not."""
        at = X_WB.inverse() @ Pose2(*here)
        moving = len(self._way) > 1 and now - self._way[-1].time_s <= MOVED_S
        comes = moving or self._makes_room(now)
        if not comes or not 0.0 < at.x < COMING_M or abs(at.y) >= ASIDE_M:
            return None
        place = X_WB @ Pose2(at.x, math.copysign(ASIDE_M + STEP_M, at.y))
        return place.x, place.y
