"""Rays and distances on an occupancy grid: what a laser at a place would measure, and whether two points see each
other.

Rays march by the distance to the nearest occupied cell (sphere tracing; Hart, The Visual Computer 12, 1996), all of a
scan at once.
"""

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
#: A ray advances at least by this (cells).
_LEAST = 0.5


class GridRays:
    """Distances on ``grid``. Cells from :data:`OCCUPIED` on are obstacles; unknown ones and what is beyond are not."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self._origin = grid.origin
        self._cell_m = grid.resolution_m
        self._occupied: NDArray[np.bool_] = grid.cells >= OCCUPIED
        # Without any obstacle, a ray leaves the grid in one step.
        cells = np.full(grid.cells.shape, float(max(grid.cells.shape)))
        if self._occupied.any():
            free = (~self._occupied).astype(np.uint8)
            cells = np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float64)
        self._steps = np.maximum(cells - _SLACK, _LEAST)

    def occupied(self, points: FloatArray) -> NDArray[np.bool_]:
        """Whether each of ``points`` (N, 2), m on the map, is in an occupied cell."""
        rows, columns, within = self._cells(points[:, 0], points[:, 1])
        found = np.zeros(len(points), np.bool_)
        found[within] = self._occupied[rows[within], columns[within]]
        return found

    def clear_m(self, x: float, y: float) -> float:
        """No obstacle is nearer to the point than this (m); 0 beyond the grid."""
        rows, columns, within = self._cells(np.array([x]), np.array([y]))
        if not within[0] or self._occupied[rows[0], columns[0]]:
            return 0.0
        step = float(self._steps[rows[0], columns[0]])
        return step * self._cell_m if step > _LEAST else 0.0

    def cast(self, x: float, y: float, directions: FloatArray, reach_m: float) -> NDArray[np.float64]:
        """Distances (N,) from the point to the first obstacle in each of ``directions`` (N; rad), to within half a
        cell; infinite where there is none within ``reach_m``."""
        ahead = np.stack((np.cos(directions), np.sin(directions)), axis=-1)
        found = np.full(len(ahead), math.inf)
        rays, gone_m = np.arange(len(ahead)), np.zeros(len(ahead))
        while rays.size:
            at = ahead[rays] * gone_m[:, None]
            rows, columns, within = self._cells(x + at[:, 0], y + at[:, 1])
            rays, gone_m, rows, columns = rays[within], gone_m[within], rows[within], columns[within]
            hit = self._occupied[rows, columns]
            found[rays[hit]] = gone_m[hit]
            gone_m = gone_m + self._steps[rows, columns] * self._cell_m
            on = ~hit & (gone_m <= reach_m)
            rays, gone_m = rays[on], gone_m[on]
        return found

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
