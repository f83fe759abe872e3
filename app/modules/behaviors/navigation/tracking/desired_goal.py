"""The goal of a desire of class GoTo."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal


def goal_of(parameters: Mapping[str, Any], before: NavigationGoal | None) -> NavigationGoal | None:
    """The goal in an intention's ``parameters``; None without ``x`` and ``y``.

    Returns ``before`` itself if the goal is the same: goals are compared by identity.
    """
    if "x" not in parameters or "y" not in parameters:
        return None
    heading = parameters.get("heading")
    goal = NavigationGoal(
        Pose2(float(parameters["x"]), float(parameters["y"]), math.nan if heading is None else float(heading)),
        float(parameters.get("tolerance_m", 0.25)),
        float(parameters.get("tolerance_rad", 0.2)),
        float(parameters.get("speed", 1.0)),
    )
    # Compared as text: a heading may be NaN, which never equals itself.
    return before if before is not None and repr(before) == repr(goal) else goal
