"""Leg inflation: room beside what may be legs, for people are wider than their legs in the scan."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan, OccupancyGrid
from app.modules.leg_detection import legs, unknown_to

#: Range (m) beyond which people are too far to matter.
_FURTHEST_M = 3.0
_RING = 12


def beside(scan: LaserScan, X_OB: Pose2, X_MO: Pose2, grid: OccupancyGrid, room_m: float) -> NDArray[np.float64]:
    """Points (N, 2), m in ``odom``, on a circle of ``room_m`` around each leg candidate that the map does not have."""
    found = legs(scan, _FURTHEST_M)
    in_space = np.column_stack((found, np.zeros(len(found))))
    middles = np.asarray((X_OB.to_pose3() @ scan.X_BL).transform(in_space)[:, :2], dtype=np.float64)
    middles = middles[unknown_to(grid, X_MO.transform(middles))]
    turns = np.linspace(0.0, 2.0 * math.pi, _RING, endpoint=False)
    ring = room_m * np.stack((np.cos(turns), np.sin(turns)), axis=-1)
    return (middles[:, None, :] + ring).reshape(-1, 2)
