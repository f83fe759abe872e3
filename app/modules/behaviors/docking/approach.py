"""The approach to a dock: a two-gain law that brings the base onto the dock's axis and along it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2, wrap_angle


@dataclass(frozen=True, slots=True)
class ApproachRules:
    """``docked_m``: distance of ``base_link`` from where the plates meet, when docked. Speeds in m/s and rad/s;
    ``slow_mps`` in the last ``slow_within_m``. ``ahead_m``: the point of the axis that is headed for lies so far ahead.
    ``turn_gain``: rad/s for each rad beside that heading."""

    docked_m: float = 0.39
    fast_mps: float = 0.15
    slow_mps: float = 0.05
    slow_within_m: float = 0.3
    ahead_m: float = 0.35
    turn_gain: float = 2.0
    turn_radps: float = 0.5


#: Beyond this angle (rad) beside the heading it turns before it drives.
_TURN_FIRST_RAD = 0.4


@dataclass(frozen=True, slots=True)
class DockOffset:
    """The base in front of a dock: ``remaining_m`` to where it is docked, ``aside_m`` to the left of the dock's axis as
    the robot looks at it, ``turned_rad`` its heading beside that axis (left positive)."""

    remaining_m: float
    aside_m: float
    turned_rad: float


def offset_of(X_DB: Pose2, rules: ApproachRules) -> DockOffset:
    """The offset of a base at ``X_DB``: the dock's x axis points at the robot."""
    return DockOffset(X_DB.x - rules.docked_m, -X_DB.y, wrap_angle(X_DB.theta - math.pi))


def approach(offset: DockOffset, rules: ApproachRules) -> tuple[float, float]:
    """Velocity (m/s, rad/s) towards the dock."""
    heading = math.atan2(-offset.aside_m, rules.ahead_m)
    error = wrap_angle(heading - offset.turned_rad)
    turn = max(-rules.turn_radps, min(rules.turn_radps, rules.turn_gain * error))
    if abs(error) > _TURN_FIRST_RAD:
        return 0.0, turn
    return rules.slow_mps if offset.remaining_m <= rules.slow_within_m else rules.fast_mps, turn
