"""What may be legs in a laser scan. Pure; navigation leaves room beside them, and persons are tracked by them.

A leg candidate is a short run of neighbouring rays in front of its background, at most ``WIDEST_M`` wide. Chairs and
posts have such runs, too: those of the map are known by it (:func:`unknown_to`), others by never walking.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.messages import LaserScan, OccupancyGrid

#: Width of a candidate (m): two shins that cover each other, 0.4 m above the floor, are no wider; one is no narrower.
NARROWEST_M, WIDEST_M = 0.04, 0.35
#: Jump of range (m) between neighbouring rays that separates two objects, and a leg from its background.
_APART_M = 0.12
#: Distance (m) from an obstacle of the map within which a run counts as that obstacle.
_ON_MAP_M = 0.15
_OCCUPIED = 65


def legs(scan: LaserScan, furthest_m: float) -> NDArray[np.float64]:
    """The middles (N, 2) of the near sides of leg candidates within ``furthest_m`` of the laser, m in its frame."""
    ranges = np.where(scan.ranges >= scan.range_min, scan.ranges, np.inf).astype(np.float64)
    ranges[ranges >= scan.range_max] = np.inf
    with np.errstate(invalid="ignore"):
        jumps = np.abs(np.diff(ranges)) > _APART_M  # two that met nothing: no jump
    begins = np.concatenate(([0], np.flatnonzero(jumps) + 1))
    ends = np.concatenate((begins[1:], [len(ranges)]))
    found = []
    for begin, end in zip(begins, ends, strict=True):
        run = ranges[begin:end]
        if end - begin < 2 or not np.isfinite(run).all() or run.min() > furthest_m:
            continue
        width = float(run.mean()) * (end - begin) * abs(scan.angle_increment)
        if not NARROWEST_M <= width <= WIDEST_M:
            continue
        left = ranges[begin - 1] if begin > 0 else math.inf
        right = ranges[end] if end < len(ranges) else math.inf
        if left < run[0] or right < run[-1]:
            continue  # a nearer object hides the rest
        angle = scan.angle_min + scan.angle_increment * (begin + end - 1) / 2
        found.append((run.min() * math.cos(angle), run.min() * math.sin(angle)))
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def unknown_to(grid: OccupancyGrid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of ``points`` (N, 2), m on the map, are away from the map's obstacles."""
    reach = math.ceil(_ON_MAP_M / grid.resolution_m)
    rows, columns = grid.cells.shape
    away = np.ones(len(points), dtype=np.bool_)
    for k, (x, y) in enumerate(points):
        row, column = (math.floor((p - q) / grid.resolution_m) for p, q in zip((y, x), grid.origin[::-1], strict=True))
        if 0 <= row < rows and 0 <= column < columns:
            around = grid.cells[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1]
            away[k] = not (around >= _OCCUPIED).any()
    return away
