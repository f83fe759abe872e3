"""Blind corners: edges between free and never seen cells, from which a person may appear, as behind a door."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.controller import DistanceField, LocalPath

#: Unseen regions up to this many cells across are gaps between rays, not corners.
_SPECK = 5


def hidden_distance(cells: NDArray[np.int8], resolution_m: float) -> NDArray[np.float32]:
    """Distance (m) from each cell's middle to the nearest unseen cell that borders on a free one; ``cells`` (H, W) as
    of an occupancy grid. Unseen cells behind a wall and small gaps do not count. 1e3 where there is none."""
    unseen = cv2.morphologyEx((cells < 0).astype(np.uint8), cv2.MORPH_OPEN, np.ones((_SPECK, _SPECK), np.uint8))
    beside_free = cv2.dilate((cells == 0).astype(np.uint8), np.ones((3, 3), np.uint8))
    edges = cv2.bitwise_and(unseen, beside_free)
    if not np.any(edges):
        return np.full(cells.shape, 1e3, dtype=np.float32)
    return np.asarray(
        cv2.distanceTransform(np.asarray(1 - edges, dtype=np.uint8), cv2.DIST_L2, cv2.DIST_MASK_3)
        * np.float32(resolution_m),
        dtype=np.float32,
    )


def careful(
    way: LocalPath, field: DistanceField, hidden: NDArray[np.float32], speed_mps: float, share: float, reach_m: float
) -> LocalPath:
    """``way`` with its speed lowered to ``share`` of ``speed_mps`` beside blind corners; the reduction fades out
    linearly at ``reach_m``."""
    points = way.points.copy()
    rows, columns = hidden.shape
    at = np.floor((points[:, :2] - np.array(field.origin)) / field.resolution_m).astype(np.int64)
    inside = (at >= 0).all(axis=1) & (at[:, 0] < columns) & (at[:, 1] < rows)
    away = np.full(len(points), np.inf)
    away[inside] = hidden[at[inside, 1], at[inside, 0]]
    points[:, 4] = np.minimum(points[:, 4], speed_mps * np.minimum(1.0, share + (1.0 - share) * away / reach_m))
    return LocalPath(points, way.spacing)
