"""The ground the body just drove over, in ``odom``: where it may back off though it does not see behind itself."""

from __future__ import annotations

import math
from collections import deque

from app.base.geometry import Pose2, wrap_angle

#: Between two remembered places.
_STEP_M = 0.04
_STEP_RAD = 0.15
#: From further off than that the body did not come by the trail: somebody drove or carried it, or odometry began anew.
_BROKEN_M = 0.5


class DrivenArea:
    """The last ``length_m`` of the way the body came, as poses."""

    def __init__(self, length_m: float = 1.5) -> None:
        self._poses: deque[Pose2] = deque(maxlen=max(2, int(length_m / _STEP_M)))

    def add(self, pose: Pose2) -> None:
        """Remember where the body is, unless it is where it was."""
        self._break_off(pose)
        if self._poses and not _apart(self._poses[-1], pose, _STEP_M, _STEP_RAD):
            return
        self._poses.append(pose)

    def back_from(self, pose: Pose2, aim_m: float = 0.3) -> Pose2 | None:
        """Where backing off steers for: the trail's pose about ``aim_m`` behind ``pose``; None at its end, and where
        the body did not come by it.

        What lies nearer than that is given up, so that the way back is not driven twice.
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
    # Pure pursuit of a body whose front is its back: which way it turns is the same for both.
    angular = speed_mps * 2.0 * math.sin(bearing) / distance
    return -speed_mps, max(-turn_radps, min(turn_radps, angular))


def _apart(a: Pose2, b: Pose2, step_m: float, step_rad: float) -> bool:
    return math.dist((a.x, a.y), (b.x, b.y)) >= step_m or abs(wrap_angle(a.theta - b.theta)) >= step_rad
