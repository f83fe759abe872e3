"""What is told of the robot's place on the map: how well scans fit there, and how little is known without."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, read_only

#: A scan of which this share lies on the map fits well; below the second it does not. Between them it may be people.
FITS, FITS_NOT = 0.6, 0.45
#: What a search by correlation leaves open of one place (m, rad).
_SIGMAS = (0.3, 0.15)


class FitWatch:
    """Whether the robot is lost: it is once scans have not fitted for ``lost_after_s``, and stays so until the share
    ``sure`` of each has lain on the map for ``sure_after_s``, for a scan or two fit everywhere. Stamps and times in s.
    """

    def __init__(self, lost_after_s: float, sure_after_s: float) -> None:
        self._lost_after_s = lost_after_s
        self._sure_after_s = sure_after_s
        self.begin()

    def begin(self, doubted: bool = False) -> None:
        """The robot was placed anew; ``doubted``: it is lost until scans fit there (``FITS`` is enough for that)."""
        self.lost = self._doubted = doubted
        self._fitted: float | None = None
        self._misfitted = 0.0
        self._misfits = 0

    def see(self, stamp: float, inliers: float, fits: bool, sure: float = FITS, least: int = 1) -> None:
        """A scan of which the share ``inliers`` lies on the map. Fewer than ``least`` in a row that do not fit say
        nothing, however far apart they are.
        """
        if self._fitted is None:
            self._fitted, self._misfitted = stamp, stamp
        if inliers < (FITS if self._doubted else sure):
            self._misfitted = stamp
        if self.lost:
            fits = stamp - self._misfitted > self._sure_after_s
        self._misfits = 0 if fits else self._misfits + 1
        if fits:
            self._fitted, self.lost, self._doubted = stamp, False, False
        self.lost = self.lost or (self._misfits >= least and self.unfit_s(stamp) > self._lost_after_s)

    def unfit_s(self, stamp: float) -> float:
        """For how long scans have not fitted now."""
        return 0.0 if self._fitted is None else stamp - self._fitted


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
    return OccupancyGrid(
        0.0,
        "map",
        cells=read_only(np.full((side, side), -1, np.int8)),
        resolution_m=cell_m,
        origin=(corner, corner),
        version=0,
    )
