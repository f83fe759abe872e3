"""Occupancy grid: views of all keyframes, drawn at the keyframes' current poses.

Each view counts once in every cell it meets: a hit where one of its rays ends, else a miss where one passes (so that a
wall seen at a grazing angle is not cleared by rays that end a little further on). Counts are sums over views, so a view
can be removed exactly and added elsewhere: a closed loop costs no more than that. The probability of occupancy is

    p = 3 h / (3 h + m),   shown as 0 up to p = 0.15 and as 100 from p = 0.85 on,

so a person who walks by vanishes after a few views through their place. Cells are on one lattice of the map's frame,
whatever part of it the grid covers.
"""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2
from app.messages import LaserScan
from app.modules.perception.slam.types import Keyframe

#: Weight of a hit, in misses.
HIT_WEIGHT = 3.0
#: Values of p shown as surely free and surely occupied.
SURELY_FREE, SURELY_OCCUPIED = 0.15, 0.85
#: Range (m) up to which rays without a return clear cells: dark and slanted surfaces give no return either.
REACH_M = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class ScanView:
    """Rays of one scan in ``base_link``: from ``sensor_xy`` (m) to ``ends`` (N, 2) float32 m; ``met`` (N,)
    bool says whether the ray met a surface.
    """

    ends: NDArray[np.float32]
    met: NDArray[np.bool_]
    sensor_xy: tuple[float, float]

    @staticmethod
    def of(keyframe: Keyframe) -> ScanView:
        sensor_xy = float(keyframe.origin[0]), float(keyframe.origin[1])
        return ScanView(keyframe.ends, np.require(keyframe.hits, requirements=("C", "W")), sensor_xy)


def view_of(scan: LaserScan) -> ScanView:
    """The view of ``scan`` with all rays cast at once, for a standing robot."""
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ranges = scan.ranges.astype(np.float64)
    met = (ranges >= scan.range_min) & (ranges < scan.range_max)
    # Readings below the least range, or NaN, are ignored.
    said = met | (ranges >= scan.range_max)
    ranges, angles, met = np.minimum(ranges, scan.range_max)[said], angles[said], met[said]
    x, y = ranges * np.cos(angles), ranges * np.sin(angles)
    turn, sensor_xy = scan.X_BL.rotation, scan.X_BL.translation
    ends = np.stack(
        (turn[0, 0] * x + turn[0, 1] * y + sensor_xy[0], turn[1, 0] * x + turn[1, 1] * y + sensor_xy[1]), axis=1
    )
    return ScanView(ends.astype(np.float32), met, (float(sensor_xy[0]), float(sensor_xy[1])))


class OccupancyCounts:
    """Hits and misses of every cell, and the cells' values; grows by whole blocks.

    ``lowest`` (column, row on the lattice): place of cell [0, 0]. Used by one thread at a time.
    """

    def __init__(self, resolution_m: float = 0.05, side_m: float = 50.0, block_m: float = 10.0) -> None:
        self.resolution_m = resolution_m
        side = max(2, 2 * round(side_m / resolution_m / 2))
        self._block = max(1, round(block_m / resolution_m))
        self.lowest = (-side // 2, -side // 2)
        self.hits: NDArray[np.uint16] = np.zeros((side, side), np.uint16)
        self.misses: NDArray[np.uint16] = np.zeros((side, side), np.uint16)
        self.cells: NDArray[np.int8] = np.full((side, side), -1, np.int8)
        self._marks: NDArray[np.int32] = np.zeros((side, side), np.int32)
        self._mark = 0
        #: First column, first row, last column, last row changed since the last :meth:`refresh`.
        self._dirty = _nowhere()

    @property
    def origin(self) -> tuple[float, float]:
        """Position of the lower left corner of cell [0, 0] (m)."""
        return self.lowest[0] * self.resolution_m, self.lowest[1] * self.resolution_m

    def add(self, view: ScanView, pose: Pose2) -> None:
        """Add ``view``, taken at ``pose`` on the map."""
        self._draw(view, pose, 1)

    def remove(self, view: ScanView, pose: Pose2) -> None:
        """Remove ``view``, which was added at exactly this ``pose``."""
        self._draw(view, pose, -1)

    def refresh(self) -> bool:
        """Recompute the cells whose counts changed; returns whether any value changed."""
        left, low, right, high = (int(v) for v in self._dirty)
        self._dirty = _nowhere()
        if right < left:
            return False
        counts = self.hits, self.misses, self.cells
        return evaluate(*counts, left, low, right, high, HIT_WEIGHT, SURELY_FREE, SURELY_OCCUPIED) > 0

    def _draw(self, view: ScanView, pose: Pose2, sign: int) -> None:
        if not len(view.ends):
            return
        # Columns and rows on the lattice of the ends, and of the sensor.
        ray_cells = self._ray_cells(view, pose)
        self._cover(ray_cells)
        self._mark += 2
        ray_cells -= np.array(self.lowest)
        cast_rays(self.hits, self.misses, self._marks, self._mark, self._dirty, ray_cells, view.met, sign)

    def _ray_cells(self, view: ScanView, pose: Pose2) -> NDArray[np.int64]:
        """(N + 1, 2): columns and rows on the lattice of the rays' ends for :func:`cast_rays`, the sensor's own
        last."""
        x, y = view.ends[:, 0].astype(np.float64), view.ends[:, 1].astype(np.float64)
        far = np.hypot(x - view.sensor_xy[0], y - view.sensor_xy[1])
        share = np.where(view.met | (far <= REACH_M), 1.0, REACH_M / np.maximum(far, 1e-9))
        x, y = view.sensor_xy[0] + share * (x - view.sensor_xy[0]), view.sensor_xy[1] + share * (y - view.sensor_xy[1])
        x, y = np.append(x, view.sensor_xy[0]), np.append(y, view.sensor_xy[1])
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        on_map = np.stack((pose.x + c * x - s * y, pose.y + s * x + c * y), axis=1)
        return np.floor(on_map / self.resolution_m).astype(np.int64)

    def _cover(self, ray_cells: NDArray[np.int64]) -> None:
        """Grow so that ``ray_cells`` are inside."""
        lowest, shape = np.array(self.lowest), np.array(self.cells.shape)[::-1]
        below = np.maximum(lowest - ray_cells.min(axis=0), 0)
        above = np.maximum(ray_cells.max(axis=0) + 1 - (lowest + shape), 0)
        if not (below.any() or above.any()):
            return
        below, above = -(-below // self._block) * self._block, -(-above // self._block) * self._block
        around = (int(below[1]), int(above[1])), (int(below[0]), int(above[0]))
        self.hits = np.pad(self.hits, around)
        self.misses = np.pad(self.misses, around)
        self.cells = np.pad(self.cells, around, constant_values=-1)
        self._marks = np.zeros(self.cells.shape, np.int32)
        self._mark = 0
        self.lowest = int(lowest[0] - below[0]), int(lowest[1] - below[1])
        if self._dirty[2] >= self._dirty[0]:
            self._dirty += np.tile(below, 2)


def cropped(cells: NDArray[np.int8], margin: int = 10) -> tuple[slice, slice]:
    """The rows and columns that contain all known cells and ``margin`` more; all if none is known."""
    known = cells >= 0
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        return slice(0, cells.shape[0]), slice(0, cells.shape[1])
    low, high = max(0, int(rows[0]) - margin), min(cells.shape[0], int(rows[-1]) + 1 + margin)
    left, right = max(0, int(columns[0]) - margin), min(cells.shape[1], int(columns[-1]) + 1 + margin)
    return slice(low, high), slice(left, right)


def _nowhere() -> NDArray[np.int64]:
    return np.array([2**40, 2**40, -1, -1], np.int64)


@kernel("void(uint16[:,::1], uint16[:,::1], int32[:,::1], int64, int64[::1], int64[:,::1], boolean[::1], int64)")
def cast_rays(hits, misses, marks, mark, dirty, ray_cells, met, sign) -> None:
    """Add one view, ``sign`` 1, or remove it, −1.

    ``ray_cells``: columns and rows inside the grid, the sensor's own cell last. ``mark``: even, greater than any value
    of ``marks``; ``marks`` hold the last view that touched each cell.
    """
    count = len(met)
    i0, j0 = ray_cells[count, 0], ray_cells[count, 1]
    for k in range(count):
        i, j = ray_cells[k, 0], ray_cells[k, 1]
        dirty[0], dirty[1] = min(dirty[0], i, i0), min(dirty[1], j, j0)
        dirty[2], dirty[3] = max(dirty[2], i, i0), max(dirty[3], j, j0)
        if met[k] and marks[j, i] != mark + 1:
            marks[j, i] = mark + 1
            hits[j, i] = hits[j, i] + sign
    for k in range(count):
        i1, j1 = ray_cells[k, 0], ray_cells[k, 1]
        # Bresenham's line, without its last cell.
        di, dj = abs(i1 - i0), -abs(j1 - j0)
        si, sj = (1 if i1 > i0 else -1), (1 if j1 > j0 else -1)
        error = di + dj
        i, j = i0, j0
        while i != i1 or j != j1:
            if marks[j, i] < mark:
                marks[j, i] = mark
                misses[j, i] = misses[j, i] + sign
            twice = 2 * error
            if twice >= dj:
                error += dj
                i += si
            if twice <= di:
                error += di
                j += sj


@kernel("int64(uint16[:,::1], uint16[:,::1], int8[:,::1], int64, int64, int64, int64, float64, float64, float64)")
def evaluate(hits, misses, cells, left, low, right, high, weight, free, occupied) -> int:
    """Write the cells' values from their counts, in these columns and rows, ends included; returns the number of
    changes."""
    changed = 0
    for j in range(low, high + 1):
        for i in range(left, right + 1):
            h, m = weight * hits[j, i], 1.0 * misses[j, i]
            value = -1
            if h + m > 0.0:
                value = round(100.0 * min(max((h / (h + m) - free) / (occupied - free), 0.0), 1.0))
            if cells[j, i] != value:
                cells[j, i] = value
                changed += 1
    return changed
