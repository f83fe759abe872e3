"""Online calibration of odometry's scale: true motion per measured metre and radian, learnt from the scans."""

from __future__ import annotations

import math

from app.base.geometry import Pose2, wrap_angle

#: Forgetting constants, in metres driven and radians turned, ...
_FORGOTTEN_M = 60.0
_FORGOTTEN_RAD = 12.0
#: ... and initial weight of the ratio 1.
_BELIEVED_M = 10.0
_BELIEVED_RAD = 4.0
#: Greatest deviation of the ratios from 1.
_MOST = 0.15
#: A correction above this share of the step (and these m, rad) is wheel slip or a wrong match.
_SLIP = 0.3
_SLIP_M = 0.02
_SLIP_RAD = 0.01
#: Turn (rad) below which a step is noise.
_LEAST_TURN_RAD = 0.03


class OdometryRatios:
    """``length`` and ``turn``: true motion as a share of odometry's.

    A matched scan corrects the predicted pose. Where the scan carries no information, as along a bare corridor, the
    correction is zero and nothing is learnt; elsewhere it equals the error of odometry since, and its sum over a path
    is the error of odometry over the path, with little noise of single scans. An integral controller adjusts each ratio
    until that sum vanishes.
    """

    def __init__(self) -> None:
        self.length = 1.0
        self.turn = 1.0
        self._driven_m = _BELIEVED_M
        self._turned_rad = _BELIEVED_RAD

    def corrected(self, step: Pose2) -> Pose2:
        """The true ``step`` of the body for odometry's ``step``."""
        return Pose2(self.length * step.x, self.length * step.y, self.turn * wrap_angle(step.theta))

    def learn(self, step: Pose2, off: Pose2) -> None:
        """Update by a match at ``off`` from the pose predicted with the corrected ``step``."""
        distance, turn = math.hypot(step.x, step.y), abs(step.theta)
        if distance > 0.0:
            self._driven_m = min(self._driven_m + distance, _FORGOTTEN_M)
            c, s = math.cos(step.theta), math.sin(step.theta)
            along = (step.x * (c * off.x - s * off.y) + step.y * (s * off.x + c * off.y)) / distance
            self.length = _moved(self.length, _unslipped(along, _SLIP_M + _SLIP * distance) / self._driven_m)
        if turn > _LEAST_TURN_RAD:
            self._turned_rad = min(self._turned_rad + turn, _FORGOTTEN_RAD)
            along = math.copysign(1.0, step.theta) * wrap_angle(off.theta)
            self.turn = _moved(self.turn, _unslipped(along, _SLIP_RAD + _SLIP * turn) / self._turned_rad)


def _unslipped(off: float, most: float) -> float:
    return off if abs(off) < most else 0.0


def _moved(ratio: float, by: float) -> float:
    return min(max(ratio * (1.0 + by), 1.0 - _MOST), 1.0 + _MOST)
