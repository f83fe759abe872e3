"""Distance field of one scan, without memory: cheap, and blind outside the current field of view."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan, Zone
from app.modules.behaviors.navigation.controller import DistanceField
from app.modules.behaviors.navigation.costmap.grid import GridFrame
from app.modules.behaviors.navigation.costmap.zone_layer import rasterize


def points_of(scan: LaserScan, X_FB: Pose2) -> NDArray[np.float64]:
    """End points (N, 2) of the scan's rays in F, ``X_FB`` being the body at its stamp; rays without a return are left
    out."""
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hit = (scan.ranges >= scan.range_min) & (scan.ranges < scan.range_max)
    ranges = scan.ranges[hit].astype(np.float64)
    rays = np.stack((ranges * np.cos(angles[hit]), ranges * np.sin(angles[hit]), np.zeros(len(ranges))), axis=1)
    return np.asarray((X_FB.to_pose3() @ scan.X_BL).transform(rays)[:, :2])


def scan_field(
    points: NDArray[np.float64],
    zones: tuple[Zone, ...],
    middle: Pose2,
    *,
    size_m: float = 4.0,
    resolution_m: float = 0.05,
) -> DistanceField:
    """Distances to ``points`` (N, 2) and to keep-out zones, all on the map, in a window around ``middle``."""
    cells = round(size_m / resolution_m)
    frame = GridFrame(middle.x - size_m / 2, middle.y - size_m / 2, resolution_m, cells, cells)
    free = np.ones((cells, cells), dtype=np.uint8)
    where, inside = frame.cells(points)
    free[where[inside, 0], where[inside, 1]] = 0
    if zones:
        keep_out, _ = rasterize(zones, frame)
        free[keep_out != 0] = 0
    if free.all():
        distances = np.full((cells, cells), size_m, dtype=np.float32)
    else:
        distances = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(resolution_m)
    return DistanceField(np.ascontiguousarray(distances, dtype=np.float32), (frame.x, frame.y), resolution_m)
