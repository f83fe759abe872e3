"""Synthetic keyframes for a map without any: simulated laser views from places all over a foreign occupancy grid."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.maps.ray_kernels import cast_grid
from app.messages import OccupancyGrid
from app.modules.perception.slam.likelihood_field import FREE, OCCUPIED
from app.modules.perception.slam.scans import BeamGeometry, prepared
from app.modules.perception.slam.types import Keyframe, SlamState

#: Spacing (m) of the places, and range (m) of the views.
APART_M, REACH_M = 1.5, 12.0
#: Preferred clearance (m) of the places.
ROOM_M = 0.3
RAYS = 720
THINNED_M = 0.03


def state_of(grid: OccupancyGrid) -> SlamState:
    """Keyframes all over the free floor of ``grid``, with simulated views all around.

    Ends are in the middle of occupied cells. Without edges: mapping cannot continue on it.
    """
    occupied = (grid.cells >= OCCUPIED).astype(np.uint8)
    unknown = (grid.cells < 0).astype(np.uint8)
    angles = np.arange(RAYS, dtype=np.float64) * (math.tau / RAYS) - math.pi
    beams = BeamGeometry(angles, 0.02, REACH_M)
    keyframes: list[Keyframe] = []
    poses: list[Pose2] = []
    for x, y in _free_cells(grid).tolist():
        column, row = (x - grid.origin[0]) / grid.resolution_m, (y - grid.origin[1]) / grid.resolution_m
        ranges = cast_grid(occupied, unknown, column, row, angles, REACH_M / grid.resolution_m) * grid.resolution_m
        scan = prepared(ranges, beams, twist=(0.0, 0.0, 0.0), sweep_s=0.0, range_max_m=REACH_M, thinning_m=THINNED_M)
        if not len(scan.points):
            continue
        id = len(keyframes)
        keyframes.append(
            Keyframe(
                id, grid.stamp, points=scan.points, ends=scan.ends, hits=scan.hits, origin=scan.origin, travelled_m=0.0
            )
        )
        poses.append(Pose2(x, y, 0.0))
    return SlamState(tuple(keyframes), tuple(poses), (), ())


def _free_cells(grid: OccupancyGrid) -> NDArray[np.float64]:
    """x, y (N, 2) of the place with most clearance in every square of free floor of APART_M on a side."""
    free = ((grid.cells >= 0) & (grid.cells <= FREE)).astype(np.uint8)
    room = np.asarray(cv2.distanceTransform(np.pad(free, 1), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))[1:-1, 1:-1]
    # Clearance beyond the preferred one does not count: then the middle of the square is chosen.
    side = max(1, round(APART_M / grid.resolution_m))
    enough = ROOM_M / grid.resolution_m
    found = []
    for top in range(0, free.shape[0], side):
        for left in range(0, free.shape[1], side):
            here = np.minimum(room[top : top + side, left : left + side], enough)
            if here.max() < 1.0:
                continue
            rows, columns = np.nonzero(here >= here.max())
            middle = np.argmin(np.hypot(rows - side / 2, columns - side / 2))
            found.append((left + columns[middle] + 0.5, top + rows[middle] + 0.5))
    cells = np.array(found, np.float64).reshape(-1, 2)
    return np.asarray(cells * grid.resolution_m + np.array(grid.origin), np.float64)
