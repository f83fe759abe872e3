"""What the collision monitor does not mind while the robot docks: the outline of the dock, and nothing else."""

from __future__ import annotations

import numpy as np

from app.base.geometry import Pose2
from app.messages import DockSighting
from app.modules.actuation.swept_footprint import Points

NEAR_M = 0.05
"""Points (m) no further from one of the dock's plates are the dock's."""
FRESH_S = 0.5
"""Greatest age (s) of a sighting."""
LONGEST_PLATE_M = 0.4
"""Plates longer than this are refused: an exemption must stay small."""


def without_dock(points: Points, dock: DockSighting, X_OS: Pose2) -> Points:
    """``points`` (N,), x + iy m in ``base_link`` at ``X_OS`` in ``odom``, without those on the plates of ``dock``."""
    turned = complex(np.cos(X_OS.theta), -np.sin(X_OS.theta))
    left, origin, right = ((corner - complex(X_OS.x, X_OS.y)) * turned for corner in dock.corners)
    keep = np.ones(len(points), dtype=bool)
    for tip in (left, right):
        plate = tip - origin
        along = ((points - origin) * plate.conjugate()).real / abs(plate) ** 2
        nearest = origin + np.clip(along, 0.0, 1.0) * plate
        keep &= np.abs(points - nearest) > NEAR_M
    return points[keep]
