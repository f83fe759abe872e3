"""The area that the body just drove over, in ``odom``: it may back off there although it does not see behind itself."""

from __future__ import annotations

import math
from collections import deque

from app.base.geometry import Pose2, wrap_angle

#: Spacing of the poses, m.
_STEP_M = 0.04
_STEP_RAD = 0.15
#: Greatest distance (m) from the last pose; further off the body was carried or odometry restarted.
_BROKEN_M = 0.5


class DrivenArea:
    """The last ``length_m`` of the body's path, as poses."""

    def __init__(self, length_m: float = 1.5) -> None:
        self._poses: deque[Pose2] = deque(maxlen=max(2, int(length_m / _STEP_M)))

    def add(self, pose: Pose2) -> None:
        """Add the body's pose if it moved."""
        self._break_off(pose)
        if self._poses and not _apart(self._poses[-1], pose, _STEP_M, _STEP_RAD):
            return
        self._poses.append(pose)

    def back_from(self, pose: Pose2, aim_m: float = 0.3) -> Pose2 | None:
        """Target of backing off: the pose about ``aim_m`` behind ``pose``; None at the end of the list, and where the
        body is off it.

        Nearer poses are removed, so that no part is driven twice.
        """
        self._break_off(pose)
        while self._poses and math.dist((self._poses[-1].x, self._poses[-1].y), (pose.x, pose.y)) < 0.5 * aim_m:
            self._poses.pop()
        for past in reversed(self._poses):
            if math.dist((past.x, past.y), (pose.x, pose.y)) >= aim_m:
                return past
        return self._poses[0] if self._poses else None

    def _break_off(self, pose: Pose2) -> None:
        if self._poses and math.dist((self._poses[-1].x, self._poses[-1].y), (pose.x, pose.y)) > _BROKEN_M:
            self._poses.clear()


def back_toward(pose: Pose2, past: Pose2, speed_mps: float, turn_radps: float) -> tuple[float, float]:
    """Linear and angular velocity that drive backward from ``pose`` to ``past``, which lies behind."""
    bearing = wrap_angle(math.atan2(past.y - pose.y, past.x - pose.x) - pose.theta - math.pi)
    if abs(bearing) > 1.0:
        return 0.0, max(-turn_radps, min(turn_radps, 1.5 * bearing))
    distance = max(0.1, math.dist((past.x, past.y), (pose.x, pose.y)))
    # Pure pursuit with the rear as the front: the sign of the turn is the same for both.
    angular = speed_mps * 2.0 * math.sin(bearing) / distance
    return -speed_mps, max(-turn_radps, min(turn_radps, angular))


def _apart(a: Pose2, b: Pose2, step_m: float, step_rad: float) -> bool:
    return math.dist((a.x, a.y), (b.x, b.y)) >= step_m or abs(wrap_angle(a.theta - b.theta)) >= step_rad
