"""Beam geometry of a scan message, projected into the plane, whichever way up the laser is mounted."""

from __future__ import annotations

import math

import numpy as np

from app.base.geometry import Pose2, Pose3
from app.messages import LaserScan
from app.modules.perception.slam.scans import BeamGeometry


class BeamCache:
    """Caches the geometry of consecutive scans with equal parameters."""

    def __init__(self) -> None:
        self._key: tuple[float, ...] = ()
        self._beams: BeamGeometry | None = None

    def __call__(self, scan: LaserScan) -> BeamGeometry:
        """The beams of ``scan``, in the order of its ranges."""
        X_BL, sign = planar(scan.X_BL)
        key = (
            len(scan.ranges), scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max,
            X_BL.x, X_BL.y, X_BL.theta, sign,
        )  # fmt: skip
        if self._beams is None or key != self._key:
            angles = sign * (scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges), dtype=np.float64))
            self._key, self._beams = key, BeamGeometry(angles, scan.range_min, scan.range_max, X_BL)
        return self._beams


def planar(X_BL: Pose3) -> tuple[Pose2, int]:
    """A laser's pose in the plane, and its sense of rotation: −1 for one mounted upside down."""
    x, y = float(X_BL.translation[0]), float(X_BL.translation[1])
    theta = math.atan2(X_BL.rotation[1, 0], X_BL.rotation[0, 0])
    return Pose2(x, y, theta), 1 if X_BL.rotation[2, 2] >= 0 else -1
