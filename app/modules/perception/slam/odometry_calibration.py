"""How far the robot goes for each metre, and turns for each radian, that odometry tells: learnt from the scans."""

from __future__ import annotations

import math

from app.base.geometry import Pose2, wrap_angle

#: What was learnt is forgotten over so many metres driven, and radians turned, ...
_FORGOTTEN_M = 60.0
_FORGOTTEN_RAD = 12.0
#: ... and at first so much weighs what is believed without.
_BELIEVED_M = 10.0
_BELIEVED_RAD = 4.0
#: Odometry is not off by more than this share.
_MOST = 0.15
#: One scan that says more than this share of the step (and so many m, rad) is a slip or another door.
_SLIP = 0.3
_SLIP_M = 0.02
_SLIP_RAD = 0.01
#: A step that turns less (rad) is noise, or a swerve.
_LEAST_TURN_RAD = 0.03


class OdometryRatios:
    """``length`` and ``turn``: the robot's own motion, as a share of what odometry tells of it.

    A scan that is matched moves the pose from where odometry led it. Where it cannot tell, as along a bare corridor,
    it moves nothing and nothing is learnt; where it can, it moves by what odometry has been off since, and sums of that
    over a way are what odometry was off over the way, without the noise of the scans between. So each ratio is moved
    by that sum until none is left (an integral controller).
    """

    def __init__(self) -> None:
        self.length = 1.0
        self.turn = 1.0
        self._driven_m = _BELIEVED_M
        self._turned_rad = _BELIEVED_RAD

    def corrected(self, step: Pose2) -> Pose2:
        """``step`` of the body as odometry tells it, as the robot went."""
        return Pose2(self.length * step.x, self.length * step.y, self.turn * wrap_angle(step.theta))

    def learn(self, step: Pose2, off: Pose2) -> None:
        """The robot, after the corrected ``step``, was found at ``off`` from where that led it."""
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
