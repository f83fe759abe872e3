"""When a path is planned again: once a period, and before that where the path is blocked, the goal moved or the pose
jumped."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal

#: Reason for planning where the goal has moved.
MOVED = "the goal moved"
#: A jump of localization by more than this (m, rad) triggers planning at once.
_JUMP = (0.15, 0.1)


@dataclass(frozen=True, slots=True)
class Planned:
    """The newest request for a path: when (s), for which goal, to which pose on the map, and ``X_MO`` then."""

    at: float
    goal: NavigationGoal
    end: Pose2
    X_MO: Pose2


def why_plan(
    now: float,
    end: Pose2,
    last: Planned | None,
    X_MO: Pose2 | None,
    *,
    wanted: str,
    is_following: bool,
    period_s: float,
    blocked_period_s: float,
) -> str | None:
    """Reason for planning a path to ``end`` at ``now``: "" for a possibly better path only; None for no planning.

    ``last`` is the newest request for the same goal, or None. ``wanted`` is why the controller or a change of zones
    asks for another path, or ""; ``is_following`` whether the robot follows a path all the same. The pose ``end`` is
    compared by identity.
    """
    if last is None:
        return "another goal"
    since = now - last.at
    if last.end is not end and since >= blocked_period_s:
        return MOVED
    if X_MO is not None and _jumped(last.X_MO, X_MO):
        return "localization corrected itself"
    if wanted and since >= blocked_period_s:
        # An obstacle for the controller need not block the path: it is replaced only by a better one or if it is bad.
        return "" if is_following else wanted
    return "" if since >= period_s else None


def _jumped(before: Pose2, now: Pose2) -> bool:
    moved = before.inverse() @ now
    return math.hypot(moved.x, moved.y) > _JUMP[0] or abs(moved.theta) > _JUMP[1]
