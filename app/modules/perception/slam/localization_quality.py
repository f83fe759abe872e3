"""Localization quality: detection of a lost robot by the fit of scans, and covariance of a set of hypotheses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, read_only

#: Least share of inliers of a good fit, and greatest of a misfit. Between them people may be the cause.
FITS, FITS_NOT = 0.6, 0.45
#: Uncertainty (m, rad) of one hypothesis after a correlative search.
_SIGMAS = (0.3, 0.15)


class FitMonitor:
    """Whether the robot is lost: after ``lost_after_s`` of misfits, until scans have had the share ``sure`` of inliers
    for ``sure_after_s``, since single scans fit by chance. Stamps and times in s."""

    def __init__(self, lost_after_s: float, sure_after_s: float) -> None:
        self._lost_after_s = lost_after_s
        self._sure_after_s = sure_after_s
        self.begin()

    def begin(self, doubted: bool = False) -> None:
        """Restart after a new pose; ``doubted``: lost until scans fit there (``FITS`` is enough for that)."""
        self.lost = self._doubted = doubted
        self._fitted: float | None = None
        self._misfitted = 0.0
        self._misfits = 0

    def see(self, stamp: float, inliers: float, fits: bool, sure: float = FITS, least: int = 1) -> None:
        """Take a scan's share of ``inliers``. Fewer than ``least`` consecutive misfits have no effect, whatever their
        time."""
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
        """Duration of the current misfits."""
        return 0.0 if self._fitted is None else stamp - self._fitted


def spread_of(hypotheses: Sequence[Pose2], grid: OccupancyGrid | None) -> NDArray[np.float64]:
    """(3, 3) covariance of x, y (m^2) and heading (rad^2) of a robot at any of ``hypotheses``, the likeliest first;
    over the whole map without hypotheses."""
    if not hypotheses:
        height, width = (0, 0) if grid is None else grid.cells.shape
        cell = 0.0 if grid is None else grid.resolution_m
        return np.diag([(width * cell) ** 2 / 12, (height * cell) ** 2 / 12, math.pi**2 / 3])
    best = hypotheses[0]
    off = np.array([(p.x - best.x, p.y - best.y, math.remainder(p.theta - best.theta, math.tau)) for p in hypotheses])
    one = np.diag([_SIGMAS[0] ** 2, _SIGMAS[0] ** 2, _SIGMAS[1] ** 2])
    return np.asarray(off.T @ off / len(off) + one, np.float64)


def empty_grid(cell_m: float, side_m: float) -> OccupancyGrid:
    """An unknown map, ``side_m`` on a side around its origin."""
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
