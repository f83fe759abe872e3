"""What is told of the robot's place on the map: how well scans fit there, and how little is known without."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.messages import OccupancyGrid, read_only

#: A scan of which this share lies on the map fits well; below the second it does not. Between them it may be people.
FITS, FITS_NOT = 0.6, 0.45
#: What a search by correlation leaves open of one place (m, rad).
_SIGMAS = (0.3, 0.15)


def spread_of(places: Sequence[Pose2], grid: OccupancyGrid | None) -> NDArray[np.float64]:
    """(3, 3) covariance of x, y (m^2) and heading (rad^2) where the robot may be at any of ``places``, the likeliest
    first; of the whole map where there is none.
    """
    if not places:
        height, width = (0, 0) if grid is None else grid.cells.shape
        cell = 0.0 if grid is None else grid.resolution_m
        return np.diag([(width * cell) ** 2 / 12, (height * cell) ** 2 / 12, math.pi**2 / 3])
    best = places[0]
    off = np.array([(p.x - best.x, p.y - best.y, math.remainder(p.theta - best.theta, math.tau)) for p in places])
    one = np.diag([_SIGMAS[0] ** 2, _SIGMAS[0] ** 2, _SIGMAS[1] ** 2])
    return np.asarray(off.T @ off / len(off) + one, np.float64)


def empty_grid(cell_m: float, side_m: float) -> OccupancyGrid:
    """A map of which nothing is known, ``side_m`` on a side around its origin."""
    side = max(2, 2 * round(side_m / cell_m / 2))
    corner = -side // 2 * cell_m
    return OccupancyGrid(0.0, "map", read_only(np.full((side, side), -1, np.int8)), cell_m, (corner, corner), 0)
