"""Progress supervision: decides what to do for a goal without progress. Pure functions.

*Distress* grows with the time without progress toward a goal. The robot first insists on the goal (raises its
intensity), then inhibits competing desire classes, and finally gives the goal up and asks people for help. Progress
restores the former state.

Sources: M. Scheutz, V. Andronache, *Architectural mechanisms for dynamic changes of behavior selection strategies in
behavior-based systems* (2004): lack of progress suspends competing behaviors, and progress restores them; F. Michaud's
EMIB (2002), where Distress deactivates one of two behaviors that have been in conflict for too long; thesis 2.1.2 and
2.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

from app.base.geometry import Pose2, wrap_angle
from app.messages import NavigationStatus

#: States of a behavior on the way to a goal.
UNDER_WAY = frozenset({"planning", "following", "recovering", "waiting"})
#: Goals within these tolerances (m, rad) are the same.
SAME_M, SAME_RAD = 1e-6, 1e-6


@dataclass(frozen=True, slots=True)
class DistressTimes:
    """Thresholds of distress, s without progress.

    ``insist_s``: insist on the goal. ``inhibit_s``: inhibit other desires. ``give_up_s``: give the goal up;
    ``unreachable_s``: the same while the behavior reports the goal unreachable. ``relief_s``: least duration of a
    measure, so that it can take effect; but a measure that left the goal without any behavior for ``unserved_s`` is
    withdrawn. ``nearer_m`` (m): least decrease of the remaining path that counts as progress, so that creeping stays
    distress.
    """

    insist_s: float = 20.0
    inhibit_s: float = 40.0
    give_up_s: float = 90.0
    unreachable_s: float = 10.0
    relief_s: float = 20.0
    unserved_s: float = 5.0
    nearer_m: float = 0.5


class Level(Enum):
    """Level of distress; each includes the measures of the lower ones."""

    CALM = 0
    INSISTING = 1
    INHIBITING = 2


@dataclass(frozen=True, slots=True)
class GoalProgress:
    """State of one goal.

    ``goal`` on the map (heading NaN: any), given at ``given`` (s, robot's clock). ``status``: the newest status of the
    behavior that serves it, None without one. ``blocked``: why the base did not drive as commanded, "" where it did.
    """

    goal: Pose2
    given: float
    status: NavigationStatus | None = None
    blocked: str = ""


@dataclass(frozen=True, slots=True)
class DistressState:
    """Memory between decisions: level and its start; time of the last manual driving; since when the goal is reported
    unreachable (None: it is not) and without a behavior; ``overreached``: insisting left the goal without a behavior
    and is not repeated; ``furthest_m``: longest remaining path since the measure began (None: not reported)."""

    goal: Pose2 | None = None
    given: float = -math.inf
    level: Level = Level.CALM
    raised: float = -math.inf
    by_hand: float = -math.inf
    unreachable: float | None = None
    unserved: float | None = None
    overreached: bool = False
    furthest_m: float | None = None


@dataclass(frozen=True, slots=True)
class GiveUp:
    """The goal is given up, and why."""

    why: str


@dataclass(frozen=True, slots=True)
class Raise:
    """Raise the level to ``level``, after ``stuck_s`` without progress."""

    level: Level
    stuck_s: float


@dataclass(frozen=True, slots=True)
class Restore:
    """Withdraw all measures; ``why`` in words."""

    why: str


Act = GiveUp | Raise | Restore


def same_goal(one: Pose2, other: Pose2) -> bool:
    """Whether both have the same place and heading; NaN equals NaN only."""
    if math.hypot(one.x - other.x, one.y - other.y) > SAME_M:
        return False
    if math.isnan(one.theta) or math.isnan(other.theta):
        return math.isnan(one.theta) and math.isnan(other.theta)
    return abs(wrap_angle(one.theta - other.theta)) <= SAME_RAD


def status_of(goal: Pose2, given: float, statuses: Iterable[NavigationStatus]) -> NavigationStatus | None:
    """The newest status about ``goal`` that is not older than ``given``; None without one."""
    about = [s for s in statuses if s.goal is not None and s.stamp >= given and same_goal(s.goal, goal)]
    return max(about, key=lambda status: status.stamp, default=None)


def decide(
    now: float,
    goal_progress: GoalProgress | None,
    before: DistressState,
    times: DistressTimes,
    *,
    by_hand: bool = False,
) -> tuple[DistressState, tuple[Act, ...]]:
    """The action at ``now`` (s) for ``goal_progress`` (None: no goal), and the next state.

    ``by_hand``: an operator drives now, which is no distress however long it takes.
    """
    if (
        goal_progress is None
        or before.goal is None
        or before.given != goal_progress.given
        or not same_goal(goal_progress.goal, before.goal)
    ):
        ended: tuple[Act, ...] = (Restore("the goal is another one"),) if before.level is not Level.CALM else ()
        if goal_progress is None:
            return DistressState(), ended
        after, acts = decide(
            now, goal_progress, DistressState(goal_progress.goal, goal_progress.given), times, by_hand=by_hand
        )
        return after, (*ended, *acts)
    state = replace(before, by_hand=now) if by_hand else before
    status = goal_progress.status
    if status is not None and status.state == "arrived":
        return DistressState(), _restored(state, "it has arrived")
    if status is None or status.state not in UNDER_WAY | {"unreachable"}:
        # Attention has selected no behavior for this goal.
        since = now if state.unserved is None else state.unserved
        state = replace(state, unreachable=None, unserved=since)
        if state.level is Level.CALM or now - since < times.unserved_s:
            return state, ()
        return replace(state, level=Level.CALM, overreached=True), _restored(state, "no behavior could serve it so")
    state = replace(state, unserved=None)
    if status.state == "unreachable":
        since = now if state.unreachable is None else state.unreachable
        state = replace(state, unreachable=since)
        if now - max(since, state.by_hand) >= times.unreachable_s:
            return DistressState(), (
                *_restored(state, "it is given up"),
                GiveUp(status.reason or "it cannot be reached"),
            )
        return state, ()
    state = replace(state, unreachable=None)
    progress = status.progress_stamp if status.progress_stamp is not None else goal_progress.given
    stuck_s = now - max(progress, goal_progress.given, state.by_hand)
    if stuck_s >= times.give_up_s:
        why = f"no progress for {stuck_s:.0f} s"
        details = "; ".join(word for word in (status.reason, goal_progress.blocked) if word)
        return DistressState(), (
            *_restored(state, "it is given up"),
            GiveUp(f"{why} ({details})" if details else why),
        )
    wanted = _level(stuck_s, times)
    if state.level is not Level.CALM and status.remaining_m is not None:
        # A detour lengthens the path: progress counts from there.
        state = replace(state, furthest_m=max(status.remaining_m, state.furthest_m or 0.0))
    if wanted.value > state.level.value and not state.overreached:
        furthest = status.remaining_m if state.level is Level.CALM else state.furthest_m
        return replace(state, level=wanted, raised=now, furthest_m=furthest), (Raise(wanted, stuck_s),)
    if state.level is not Level.CALM and wanted is Level.CALM and now - state.raised >= times.relief_s:
        far, left = state.furthest_m, status.remaining_m
        if far is not None and left is not None and far - left < times.nearer_m:
            return state, ()
        return replace(state, level=Level.CALM, furthest_m=None), (Restore("it gets on again"),)
    return state, ()


def _level(stuck_s: float, times: DistressTimes) -> Level:
    if stuck_s >= times.inhibit_s:
        return Level.INHIBITING
    return Level.INSISTING if stuck_s >= times.insist_s else Level.CALM


def _restored(state: DistressState, why: str) -> tuple[Act, ...]:
    return (Restore(why),) if state.level is not Level.CALM else ()
