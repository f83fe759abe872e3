"""The dock's pose in ``odom``, averaged over scans: it does not move there while the robot approaches."""

from __future__ import annotations

import math

from app.base.geometry import Pose2, wrap_angle

#: Number of scans that the average goes back.
_SPAN = 15
#: Measurements further from the estimate (m, rad) are ignored; so many in a row begin another estimate.
_OUTLIER = (0.08, math.radians(8))
_PATIENCE = 8


class DockFilter:
    """The estimate; ``sure_after`` measurements make it one to drive by."""

    def __init__(self, sure_after: int = 10) -> None:
        self._sure_after = sure_after
        self.reset()

    def reset(self) -> None:
        """Forget the dock."""
        self._count = 0
        self._outliers = 0
        #: ``X_OD``; None before the first measurement.
        self.estimate: Pose2 | None = None
        #: Time of the newest measurement (s, robot's clock).
        self.stamp = -math.inf

    @property
    def is_sure(self) -> bool:
        """Whether enough measurements agree."""
        return self._count >= self._sure_after

    def add(self, stamp: float, X_OD: Pose2) -> None:
        """Take a measurement of a scan at ``stamp``."""
        before = self.estimate
        if before is not None and _is_outlier(before, X_OD):
            self._outliers += 1
            if self._outliers < _PATIENCE:
                return
            self.reset()
            before = None
        self._outliers = 0
        self._count += 1
        self.stamp = stamp
        self.estimate = X_OD if before is None else before.interpolate(X_OD, max(1 / self._count, 1 / _SPAN))


def _is_outlier(before: Pose2, now: Pose2) -> bool:
    apart = math.hypot(now.x - before.x, now.y - before.y)
    return apart > _OUTLIER[0] or abs(wrap_angle(now.theta - before.theta)) > _OUTLIER[1]
