"""Progress supervision: when a goal is reached, and what is done about one that is not neared. A pure decision.

No progress is *distress*: it grows with the time that a goal has not been neared. At first the robot insists on the
goal, then it silences what competes with it, in the end it gives the goal up and asks people for help; when it gets on
again, everything is as it was before.

Sources: M. Scheutz, V. Andronache, *Architectural mechanisms for dynamic changes of behavior selection strategies in
behavior-based systems* (2004): no progress cuts what holds the robot up, and restores it later; F. Michaud's EMIB
(2002), where Distress deactivates one of two behaviors that have been in conflict for too long; thesis 2.1.2 and 2.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

from app.base.geometry import Pose2, wrap_angle
from app.messages import NavigationStatus

#: What a behavior is about while it has a goal that it has not reached.
UNDER_WAY = frozenset({"planning", "following", "recovering", "waiting"})
#: Goals nearer than this (m, rad) are the same one.
SAME_M, SAME_RAD = 1e-6, 1e-6


@dataclass(frozen=True, slots=True)
class DistressTimes:
    """Times in s. Without progress for ``insist_s`` the robot insists, for ``inhibit_s`` it inhibits others, for
    ``give_up_s`` it gives up; a goal called unreachable for ``unreachable_s`` is given up too. What was done about it
    stands for ``relief_s`` at least, so that it can help; but where it has led to nobody's going there for
    ``unserved_s``, it was too much to ask for. It gets on again once it is
    ``nearer_m`` (m) nearer: a robot that creeps is in distress all the same."""

    insist_s: float = 20.0
    inhibit_s: float = 40.0
    give_up_s: float = 90.0
    unreachable_s: float = 10.0
    relief_s: float = 20.0
    unserved_s: float = 5.0
    nearer_m: float = 0.5


class Level(Enum):
    """What is done about distress; each goes on with what was done before."""

    CALM = 0
    INSISTING = 1
    INHIBITING = 2


@dataclass(frozen=True, slots=True)
class GoalProgress:
    """What the robot was sent to do, and how it fares.

    ``goal`` on the map (a heading that nobody asked for is NaN), given at ``given`` (s, robot's clock). ``status`` is
    what the behavior that goes there says, None while none does. ``blocked`` says why the base did not drive as
    commanded, "" where it did.
    """

    goal: Pose2
    given: float
    status: NavigationStatus | None = None
    blocked: str = ""


@dataclass(frozen=True, slots=True)
class DistressState:
    """What is remembered of the errand: what is done about it, since when; when people drove last; since when the goal
    has been called unreachable (None: it is not) and nobody has gone there; ``overreached``: that came of insisting,
    which is not tried again; ``furthest_m``: how long its way was at most since something is done about it (None:
    nobody has said)."""

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
class Arrived:
    """The goal is reached: its desire is fulfilled."""


@dataclass(frozen=True, slots=True)
class GiveUp:
    """The goal is given up, and why."""

    why: str


@dataclass(frozen=True, slots=True)
class Raise:
    """Go to ``level``, after ``stuck_s`` without progress."""

    level: Level
    stuck_s: float


@dataclass(frozen=True, slots=True)
class Restore:
    """Everything is to be as it was before; ``why`` in words."""

    why: str


Act = Arrived | GiveUp | Raise | Restore


def same_goal(one: Pose2, other: Pose2) -> bool:
    """Whether both are one place and heading; nobody's heading (NaN) equals itself alone."""
    if math.hypot(one.x - other.x, one.y - other.y) > SAME_M:
        return False
    if math.isnan(one.theta) or math.isnan(other.theta):
        return math.isnan(one.theta) and math.isnan(other.theta)
    return abs(wrap_angle(one.theta - other.theta)) <= SAME_RAD


def status_of(goal: Pose2, given: float, statuses: Iterable[NavigationStatus]) -> NavigationStatus | None:
    """Of what behaviors say, the newest that is about ``goal``, and not from before it was ``given``."""
    about = [s for s in statuses if s.goal is not None and s.stamp >= given and same_goal(s.goal, goal)]
    return max(about, key=lambda status: status.stamp, default=None)


def decide(
    now: float, errand: GoalProgress | None, before: DistressState, patience: DistressTimes, *, by_hand: bool = False
) -> tuple[DistressState, tuple[Act, ...]]:
    """What is done at ``now`` (s) about the ``errand`` (None: nobody wants to go anywhere), and what is remembered.

    ``by_hand``: people drive just now, which is no distress, however long it takes.
    """
    if errand is None or before.goal is None or before.given != errand.given or not same_goal(errand.goal, before.goal):
        ended: tuple[Act, ...] = (Restore("the goal is another one"),) if before.level is not Level.CALM else ()
        if errand is None:
            return DistressState(), ended
        after, acts = decide(now, errand, DistressState(errand.goal, errand.given), patience, by_hand=by_hand)
        return after, (*ended, *acts)
    state = replace(before, by_hand=now) if by_hand else before
    status = errand.status
    if status is not None and status.state == "arrived":
        return DistressState(), (*_restored(state, "it has arrived"), Arrived())
    if status is None or status.state not in UNDER_WAY | {"unreachable"}:
        # Attention has given this errand to nobody.
        since = now if state.unserved is None else state.unserved
        state = replace(state, unreachable=None, unserved=since)
        if state.level is Level.CALM or now - since < patience.unserved_s:
            return state, ()
        return replace(state, level=Level.CALM, overreached=True), _restored(state, "nobody could go there so")
    state = replace(state, unserved=None)
    if status.state == "unreachable":
        since = now if state.unreachable is None else state.unreachable
        state = replace(state, unreachable=since)
        if now - max(since, state.by_hand) >= patience.unreachable_s:
            return DistressState(), (
                *_restored(state, "it is given up"),
                GiveUp(status.reason or "it cannot be reached"),
            )
        return state, ()
    state = replace(state, unreachable=None)
    progress = status.progress_stamp if status.progress_stamp is not None else errand.given
    stuck_s = now - max(progress, errand.given, state.by_hand)
    if stuck_s >= patience.give_up_s:
        why = f"no progress for {stuck_s:.0f} s"
        details = "; ".join(word for word in (status.reason, errand.blocked) if word)
        return DistressState(), (
            *_restored(state, "it is given up"),
            GiveUp(f"{why} ({details})" if details else why),
        )
    wanted = _level(stuck_s, patience)
    if state.level is not Level.CALM and status.remaining_m is not None:
        # A detour makes the way longer: getting on is from there.
        state = replace(state, furthest_m=max(status.remaining_m, state.furthest_m or 0.0))
    if wanted.value > state.level.value and not state.overreached:
        furthest = status.remaining_m if state.level is Level.CALM else state.furthest_m
        return replace(state, level=wanted, raised=now, furthest_m=furthest), (Raise(wanted, stuck_s),)
    if state.level is not Level.CALM and wanted is Level.CALM and now - state.raised >= patience.relief_s:
        far, left = state.furthest_m, status.remaining_m
        if far is not None and left is not None and far - left < patience.nearer_m:
            return state, ()
        return replace(state, level=Level.CALM, furthest_m=None), (Restore("it gets on again"),)
    return state, ()


def _level(stuck_s: float, patience: DistressTimes) -> Level:
    if stuck_s >= patience.inhibit_s:
        return Level.INHIBITING
    return Level.INSISTING if stuck_s >= patience.insist_s else Level.CALM


def _restored(state: DistressState, why: str) -> tuple[Act, ...]:
    return (Restore(why),) if state.level is not Level.CALM else ()
