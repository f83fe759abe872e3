"""Surfel grids: the readings of a few keyframes, as one small surface element per cell."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2

#: Side of a cell (m): enough readings of a wall per cell, and the two sides of a door in different cells.
CELL_M = 0.1
#: Coordinate (m) of the mean of a cell without surfel: far away.
NOWHERE = 1e6
#: Border (cells): the widest neighbourhood of a search.
MARGIN = 4
#: Growth (cells) of a grid.
_ROOM = 48
#: Number of readings from which a cell forgets old ones.
_FULL = 30.0


class SurfelGrid:
    """A growing grid of surfels, in the submap's frame.

    ``surfels`` (H, W, 4) float32: mean of the readings in the cell (m; NOWHERE if none) and the surface's unit normal
    (0, 0 where readings disagree). Cell [i, j] covers x from ``(corner[0] + i) * CELL_M`` and y from ``(corner[1] + j)
    * CELL_M``.
    """

    def __init__(self) -> None:
        self.corner = (0, 0)
        self.surfels = _empty((0, 0))
        self._sums = np.zeros((0, 0, 5), np.float32)

    def insert(self, points: NDArray[np.float32], X_SB: Pose2) -> None:
        """Insert ``points`` (N, 4) of a scan taken at ``X_SB`` of the submap."""
        if not len(points):
            return
        self._make_room(points, X_SB)
        _insert(self._sums, self.surfels, *self.corner, points, X_SB.x, X_SB.y, X_SB.theta)

    def _make_room(self, points: NDArray[np.float32], pose: Pose2) -> None:
        low_i, low_j, high_i, high_j = _bounds(points, pose.x, pose.y, pose.theta)
        low = np.array([low_i - MARGIN, low_j - MARGIN])
        high = np.array([high_i + MARGIN + 1, high_j + MARGIN + 1])
        rows, columns = self.surfels.shape[:2]
        if rows:
            had_low = np.array(self.corner)
            had_high = had_low + np.array([rows, columns])
            if (low >= had_low).all() and (high <= had_high).all():
                return
            # Grows only on the sides where it is too small, with room for the next scans.
            low = np.where(low < had_low, low - _ROOM, had_low)
            high = np.where(high > had_high, high + _ROOM, had_high)
        size = (int(high[0] - low[0]), int(high[1] - low[1]))
        sums = np.zeros((*size, 5), np.float32)
        surfels = _empty(size)
        if rows:
            i, j = (int(v) for v in had_low - low)
            sums[i : i + rows, j : j + columns] = self._sums
            surfels[i : i + rows, j : j + columns] = self.surfels
        self.corner = (int(low[0]), int(low[1]))
        self._sums, self.surfels = sums, surfels


def surfel_grid(scans: Iterable[tuple[NDArray[np.float32], Pose2]]) -> SurfelGrid:
    """The grid of ``scans``: points (N, 4) and the pose of each in the grid's frame."""
    grid = SurfelGrid()
    for points, pose in scans:
        grid.insert(points, pose)
    return grid


def _empty(size: tuple[int, int]) -> NDArray[np.float32]:
    surfels = np.zeros((*size, 4), np.float32)
    surfels[..., :2] = NOWHERE
    return surfels


@kernel("UniTuple(int64, 4)(float32[:, ::1], float64, float64, float64)")
def _bounds(points, x, y, theta) -> tuple[int, int, int, int]:
    """First and last cells (i, j, i, j) of the points."""
    c = math.cos(theta)
    s = math.sin(theta)
    low_x = low_y = 1e9
    high_x = high_y = -1e9
    for k in range(len(points)):
        px = c * points[k, 0] - s * points[k, 1] + x
        py = s * points[k, 0] + c * points[k, 1] + y
        low_x = min(low_x, px)
        high_x = max(high_x, px)
        low_y = min(low_y, py)
        high_y = max(high_y, py)
    return (
        math.floor(low_x / CELL_M),
        math.floor(low_y / CELL_M),
        math.floor(high_x / CELL_M),
        math.floor(high_y / CELL_M),
    )


@kernel(
    "void(float32[:, :, ::1], float32[:, :, ::1], int64, int64, float32[:, ::1], float64, float64, float64)",
    fastmath=True,
)
def _insert(sums, surfels, corner_i, corner_j, points, x, y, theta) -> None:
    c = math.cos(theta)
    s = math.sin(theta)
    for k in range(len(points)):
        px = c * points[k, 0] - s * points[k, 1] + x
        py = s * points[k, 0] + c * points[k, 1] + y
        i = math.floor(px / CELL_M) - corner_i
        j = math.floor(py / CELL_M) - corner_j
        total = sums[i, j]
        if total[4] >= _FULL:
            for q in range(5):
                total[q] *= 0.9
        total[0] += px
        total[1] += py
        total[2] += c * points[k, 2] - s * points[k, 3]
        total[3] += s * points[k, 2] + c * points[k, 3]
        total[4] += 1.0
        surfel = surfels[i, j]
        n = total[4]
        surfel[0] = total[0] / n
        surfel[1] = total[1] / n
        length = math.sqrt(total[2] * total[2] + total[3] * total[3])
        # Normals that cancel each other define no surface.
        agree = length > 0.5 * n
        surfel[2] = total[2] / length if agree else 0.0
        surfel[3] = total[3] / length if agree else 0.0
