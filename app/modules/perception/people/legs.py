"""Where persons may stand, by their legs in a scan: pairs of leg candidates, and single ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan, OccupancyGrid
from app.modules.leg_detection import legs, unknown_to
from app.modules.perception.people.values import LegsSeen

#: Greatest distance (m) of the two legs of a person who walks.
_STRIDE_M = 0.5
#: Radius of a leg (m), whose near side the laser sees.
_RADIUS_M = 0.05
#: Standard deviations (m) of a person's place by both legs and by one: the other is hidden, or before, or behind.
_BOTH_M, _ONE_M = 0.08, 0.17


def paired(points: NDArray[np.float64]) -> list[tuple[int, ...]]:
    """Indices of ``points`` (N, 2) m that are legs of one person: two that are each other's nearest, or one."""
    count = len(points)
    if count < 2:
        return [(i,) for i in range(count)]
    apart = np.hypot(*(points[:, None] - points[None]).T)
    np.fill_diagonal(apart, math.inf)
    nearest = apart.argmin(axis=1)
    pairs: list[tuple[int, ...]] = []
    for i in range(count):
        j = int(nearest[i])
        if apart[i, j] <= _STRIDE_M and nearest[j] == i:
            if i < j:
                pairs.append((i, j))
        else:
            pairs.append((i,))
    return pairs


def legs_seen(
    scan: LaserScan, X_OB: Pose2, furthest_m: float, grid: OccupancyGrid | None, X_MO: Pose2 | None
) -> list[LegsSeen]:
    """What may be persons in ``scan``, the robot at ``X_OB``; nothing is known without a map, or a place on it."""
    found = legs(scan, furthest_m)
    if not len(found):
        return []
    found = found * (1 + _RADIUS_M / np.hypot(*found.T))[:, None]
    in_space = np.column_stack((found, np.zeros(len(found))))
    points = np.asarray((X_OB.to_pose3() @ scan.X_BL).transform(in_space)[:, :2], np.float64)
    away = np.ones(len(points), np.bool_) if grid is None or X_MO is None else unknown_to(grid, X_MO.transform(points))
    candidates = []
    for members in paired(points):
        sigma = _BOTH_M if len(members) == 2 else _ONE_M
        rows = list(members)
        candidates.append(LegsSeen(points[rows].mean(axis=0), sigma**2 * np.eye(2), not away[rows].any()))
    return candidates
