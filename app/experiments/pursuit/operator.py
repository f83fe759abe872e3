"""The scripted operator: where to steer, by what the page shows. No clock, and nothing of the truth.

The same hands in all conditions: they steer along the way that the person took (or the course), at full stick where it
is straight, away from what the laser shows near the sides. What differs is where the robot is taken to be: where it
was measured, or where the page predicts it; and, in Mode 2, that the view stays on the person, and the head follows it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.base.geometry import Pose2, wrap_angle
from app.base.motion_prediction import Commanded, Motion, Velocity, predicted
from app.experiments.pursuit.remote_console import Hands, Shown
from app.experiments.pursuit.view_follow import STILL, Follow, follow
from app.experiments.script import lean
from app.link import BaseLimits

#: Between two commands (s), as of the page; and from seeing to acting, as of a practised person (s).
PERIOD_S, REACTION_S = 0.05, 0.2
#: The point to steer at is so far along the way (m); it is reached within so much.
LOOKAHEAD_M, REACHED_M = 0.5, 0.2
#: Distance to keep from the person (m), and how much stick each metre more is worth.
KEPT_M, STICK_PER_M = 1.2, 2.0
#: Turns on the spot from the first angle on, until within the second (rad).
TURN_FIRST_RAD, TURNED_RAD = 0.7, 0.25
STICK_PER_RAD = 1.6
#: A hand does not correct less than this in Mode 2, where the view turns the base (rad).
LET_VIEW_RAD = 0.12
#: A trail is of points so far apart (m).
TRAIL_M = 0.15
#: Who holds the stick and does not move (m, rad) for so long (s) backs off for a moment (s), at this share.
_STUCK_M, _STUCK_RAD, STUCK_S, BACK_S, BACK_STICK = 0.03, 0.05, 2.0, 1.5, -0.5
#: How fast a hand turns the view (rad/s), and how long the person is taken to walk on while unseen (s).
VIEW_RADPS, WALKS_ON_S = 1.8, 2.0
_KEPT_S = 3.0

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Style:
    """How is driven: in ``mode`` 1 or 2, with ``prediction`` or without."""

    mode: int = 1
    prediction: bool = False


class Operator:
    """Drives a body with ``limits`` along ``course``, or, with none, after the person."""

    def __init__(self, style: Style, limits: BaseLimits, course: Sequence[Point] = ()) -> None:
        self._style = style
        self._limits = limits
        self._following = not course
        self._way: deque[Point] = deque(course)
        self._turning = False
        self._sent: list[Commanded] = []
        self._last: tuple[float, Point] | None = None
        self._velocity = (0.0, 0.0)
        self._view: float | None = None
        self._follow: Follow = STILL
        self._stood: tuple[float, Pose2] | None = None
        self._back_until = -math.inf
        self._late: deque[Hands] = deque([Hands()] * round(REACTION_S / PERIOD_S))

    @property
    def arrived(self) -> bool:
        """Whether the course is driven to its end."""
        return not self._following and not self._way

    def act(self, now: float, shown: Shown, round_trip_s: float) -> Hands:
        """What is held at ``now`` (s); to be called each ``PERIOD_S``."""
        self._watch(shown)
        arrives = now + 0.5 * round_trip_s
        X_WB = self._taken_to_be(shown, arrives)
        self._late.append(self._unstuck(self._steer(X_WB, shown), shown, now))
        hands = self._late.popleft()
        velocity = Velocity(hands.linear * self._limits.linear_mps, hands.angular * self._limits.angular_radps)
        self._sent = [each for each in self._sent if each.stamp > now - _KEPT_S]
        latest = self._sent[-1].stamp if self._sent else arrives
        self._sent.append(Commanded(max(arrives, latest), velocity if hands.held else Velocity()))
        return hands

    def _taken_to_be(self, shown: Shown, arrives: float) -> Pose2:
        if not self._style.prediction:
            return shown.X_WB
        motion = Motion(shown.stamp, shown.X_WB, shown.velocity)
        limits = self._limits
        return predicted(
            motion,
            self._sent,
            arrives,
            linear_mps2=limits.linear_mps2,
            angular_radps2=limits.angular_radps2,
        ).X_OB

    def _watch(self, shown: Shown) -> None:
        """Remember where the person was seen, and the way they took."""
        if shown.person is None or (self._last is not None and shown.stamp <= self._last[0]):
            return
        if self._last is not None:
            seconds = shown.stamp - self._last[0]
            share = min(1.0, seconds / 0.5)
            speeds = ((new - old) / seconds for new, old in zip(shown.person, self._last[1], strict=True))
            self._velocity = tuple(  # type: ignore[assignment]
                before + share * (speed - before) for before, speed in zip(self._velocity, speeds, strict=True)
            )
        self._last = shown.stamp, shown.person
        if self._following and (not self._way or math.dist(self._way[-1], shown.person) > TRAIL_M):
            self._way.append(shown.person)

    def _expected(self, stamp: float) -> Point | None:
        """Where the person is looked for: where they were seen, or a little further on."""
        if self._last is None:
            return None
        seen, (x, y) = self._last
        unseen_s = min(stamp - seen, WALKS_ON_S)
        return x + self._velocity[0] * unseen_s, y + self._velocity[1] * unseen_s

    def _steer(self, X_WB: Pose2, shown: Shown) -> Hands:
        person = self._expected(shown.stamp) if self._following else None
        target = self._target(X_WB) or person
        linear = angular = 0.0
        if target is not None:
            near = person is not None and math.dist((X_WB.x, X_WB.y), person) < KEPT_M
            aim = person if near and person is not None else target
            linear, angular = self._towards(_bearing(X_WB, aim), shown)
            if person is not None:
                room = math.dist((X_WB.x, X_WB.y), person) - KEPT_M
                linear *= min(max(STICK_PER_M * room, 0.0), 1.0)
        if self._style.mode == 2:
            return self._with_view(X_WB, person or target, shown, (linear, angular))
        return Hands(held=linear != 0.0 or angular != 0.0, linear=linear, angular=angular)

    def _unstuck(self, hands: Hands, shown: Shown, now: float) -> Hands:
        """``hands``, or a moment's drive back where they have moved nothing for long."""
        if now < self._back_until:
            return replace(hands, held=True, linear=BACK_STICK, angular=0.0)
        here = shown.X_WB
        if self._stood is None or not hands.held or _moved(self._stood[1], here):
            self._stood = now, here
        elif now - self._stood[0] > STUCK_S:
            self._back_until, self._stood = now + BACK_S, None
        return hands

    def _target(self, X_WB: Pose2) -> Point | None:
        """The point of the way to steer at: what is behind is left; the last one of a course must be reached."""
        here = X_WB.x, X_WB.y
        while len(self._way) > 1:
            ends = self._way[0], self._way[1]
            if math.dist(here, ends[0]) < REACHED_M or _passed(here, *ends):
                self._way.popleft()
            else:
                break
        if not self._way:
            return None
        if len(self._way) == 1 and math.dist(here, self._way[0]) < REACHED_M:
            if not self._following:
                self._way.popleft()
            return None
        return self._along(here)

    def _along(self, here: Point) -> Point:
        """``LOOKAHEAD_M`` along what is left of the way."""
        left, at = LOOKAHEAD_M, here
        for point in self._way:
            step = math.dist(at, point)
            if step >= left:
                share = left / step
                return at[0] + share * (point[0] - at[0]), at[1] + share * (point[1] - at[1])
            left, at = left - step, point
        return at

    def _towards(self, error: float, shown: Shown) -> tuple[float, float]:
        self._turning = abs(error) > (TURNED_RAD if self._turning else TURN_FIRST_RAD)
        turn = STICK_PER_RAD * error
        if self._turning:
            return 0.0, _within(turn)
        if shown.scan is not None:
            turn += lean(shown.scan)
        return max(0.2, math.cos(error) - 0.8 * abs(error)), _within(turn)

    def _with_view(self, X_WB: Pose2, look: Point | None, shown: Shown, stick: tuple[float, float]) -> Hands:
        """Mode 2: the view is turned to ``look``, head and base follow it where no hand turns them."""
        linear, angular = stick
        if self._view is None:
            self._view = X_WB.theta
        if look is not None:
            wanted = math.atan2(look[1] - X_WB.y, look[0] - X_WB.x)
            most = VIEW_RADPS * PERIOD_S
            self._view += min(max(wrap_angle(wanted - self._view), -most), most)
        bearing = math.degrees(wrap_angle(self._view - X_WB.theta))
        self._follow = follow(self._follow, bearing, math.degrees(shown.pan), passed=PERIOD_S)
        if abs(angular) < STICK_PER_RAD * LET_VIEW_RAD or linear == 0.0:
            by_hand = 0.0 if abs(angular) < STICK_PER_RAD * TURNED_RAD else angular
            angular = by_hand or self._follow.angular
        held = linear != 0.0 or angular != 0.0
        return Hands(held, linear, angular, head_held=True, pan=self._follow.pan)


def _bearing(X_WB: Pose2, point: Point) -> float:
    return wrap_angle(math.atan2(point[1] - X_WB.y, point[0] - X_WB.x) - X_WB.theta)


def _passed(here: Point, a: Point, b: Point) -> bool:
    """Whether ``here`` is beside the leg from ``a`` to ``b``, past its begin."""
    leg = b[0] - a[0], b[1] - a[1]
    along = leg[0] * (here[0] - a[0]) + leg[1] * (here[1] - a[1])
    return along > 0.0 and math.dist(here, a) < 2 * REACHED_M


def _moved(a: Pose2, b: Pose2) -> bool:
    return math.dist((a.x, a.y), (b.x, b.y)) > _STUCK_M or abs(wrap_angle(a.theta - b.theta)) > _STUCK_RAD


def _within(stick: float) -> float:
    return min(max(stick, -1.0), 1.0)
