"""Rays and distances on an occupancy grid: what a laser at a place would measure, and whether two points see each
other."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FloatArray
from app.maps.place_checks import OCCUPIED
from app.messages import OccupancyGrid

#: Half a cell's diagonal, of the cell where a ray is and of the occupied one: so much nearer than its middle an
#: obstacle may be (cells).
_SLACK = math.sqrt(2.0)


class GridRays:
    """Distances on ``grid``. Cells from :data:`OCCUPIED` on are obstacles; unknown ones and what is beyond are not."""

    def __init__(self, grid: OccupancyGrid) -> None:
        # Late: numba takes a second of each program that starts, also of those that cast no ray.
        from app.maps.ray_kernels import cast_grid

        self._cast_grid = cast_grid
        self._origin = grid.origin
        self._cell_m = grid.resolution_m
        self._occupied = (grid.cells >= OCCUPIED).astype(np.uint8)
        self._unknown = np.zeros_like(self._occupied)
        # Without any obstacle, the grid's size.
        cells = np.full(grid.cells.shape, float(max(grid.cells.shape)))
        if self._occupied.any():
            free = 1 - self._occupied
            cells = np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float64)
        self._clear_m = np.maximum(cells - _SLACK, 0.0) * self._cell_m

    def occupied(self, points: FloatArray) -> NDArray[np.bool_]:
        """Whether each of ``points`` (N, 2), m on the map, is in an occupied cell."""
        rows, columns, within = self._cells(points[:, 0], points[:, 1])
        found = np.zeros(len(points), np.bool_)
        found[within] = self._occupied[rows[within], columns[within]] != 0
        return found

    def clear_m(self, x: float, y: float) -> float:
        """No obstacle is nearer to the point than this (m); 0 beyond the grid."""
        rows, columns, within = self._cells(np.array([x]), np.array([y]))
        return float(self._clear_m[rows[0], columns[0]]) if within[0] else 0.0

    def cast(self, x: float, y: float, directions: FloatArray, reach_m: float) -> NDArray[np.float64]:
        """Distances (N,) from the point to the first obstacle in each of ``directions`` (N; rad), to within half a
        cell; infinite where there is none within ``reach_m``."""
        column, row = ((at - begin) / self._cell_m for at, begin in zip((x, y), self._origin, strict=True))
        reach = reach_m / self._cell_m
        ranges = self._cast_grid(self._occupied, self._unknown, column, row, np.ascontiguousarray(directions), reach)
        # Comparison with NaN, which rays beyond the grid have, is false.
        return np.where(ranges < reach, ranges * self._cell_m, np.inf)

    def sees(self, a: tuple[float, float], b: tuple[float, float]) -> bool:
        """Whether no obstacle is between the points ``a`` and ``b`` (m on the map)."""
        away = math.dist(a, b)
        towards = np.array([math.atan2(b[1] - a[1], b[0] - a[0])])
        return math.isinf(float(self.cast(*a, directions=towards, reach_m=away)[0]))

    def _cells(self, x: FloatArray, y: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """Rows and columns of the points, and whether each is on the grid."""
        height, width = self._occupied.shape
        columns = np.floor((x - self._origin[0]) / self._cell_m).astype(np.intp)
        rows = np.floor((y - self._origin[1]) / self._cell_m).astype(np.intp)
        return rows, columns, (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
