"""When the robot is lost, and the course of its relocalization: requested, running, ended.

The search itself is :mod:`relocalization`; the caller runs its steps in another thread.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from app.base.geometry import Pose2
from app.messages import LaserScan, Localization, OccupancyGrid
from app.modules.perception.slam.localization_quality import FITS_NOT, FitMonitor, spread_of
from app.modules.perception.slam.types import MOST_SUGGESTED, Match

if TYPE_CHECKING:  # kernels are compiled or loaded on import
    from app.modules.perception.slam.relocalization import PoseHypothesis, PoseSearch

#: Number of consecutive misfitting scans that odometry bridges on a growing map, whatever their time ...
_LEAST_MISFITS = 3
#: ... and inlier share from which the map grows again: long walls are similar, and errors stay on the map.
_SURE = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class SearchStep:
    """A scan for ``search``, with the body at ``X_OB``, and poses X_MO ``suggested`` by landmarks since the last."""

    search: PoseSearch
    scan: LaserScan
    X_OB: Pose2
    suggested: tuple[Pose2, ...]

    def run(self) -> tuple[Pose2 | None, tuple[PoseHypothesis, ...]]:
        """*Behind.* X_MO if a hypothesis is accepted, and all hypotheses, the likeliest first."""
        from app.modules.perception.slam.occupancy import view_of
        from app.modules.perception.slam.relocalization import SearchScan

        search = self.search
        for X_MO in self.suggested:
            search.suggest(X_MO)
        view = view_of(self.scan)
        points = view.ends[view.met].astype(np.float64)
        return search.see(SearchScan(points, np.array(view.sensor_xy), self.X_OB)), search.hypotheses


class Relocalizer:
    """On a map that does not grow, a search follows ``search_after_s`` of misfitting scans; on a growing map, odometry
    bridges them, and the robot is lost. ``lost_after_s``, ``sure_after_s``: as of :class:`FitMonitor`."""

    def __init__(self, *, lost_after_s: float, search_after_s: float, sure_after_s: float) -> None:
        self._search_after_s = search_after_s
        self._fits = FitMonitor(lost_after_s, sure_after_s)
        self.end()

    def end(self, *, doubted: bool = False) -> None:
        """The robot has a new pose, and no search goes on; ``doubted``: it is lost until scans fit there."""
        self._requested = False
        self._search: PoseSearch | None = None
        self._hypotheses: tuple[PoseHypothesis, ...] = ()
        self._scan: tuple[LaserScan, Pose2] | None = None
        #: Poses X_MO by landmarks.
        self._suggested: deque[Pose2] = deque(maxlen=MOST_SUGGESTED)
        self._fits.begin(doubted)

    @property
    def lost(self) -> bool:
        """Whether scans have not fitted the map for a while."""
        return self._fits.lost

    @property
    def due(self) -> bool:
        """Whether a search is requested and does not go on yet."""
        return self._requested and self._search is None

    @property
    def running(self) -> bool:
        """Whether a search goes on."""
        return self._search is not None

    @property
    def doubtful(self) -> bool:
        """Whether the pose may be wrong: the map does not grow then, and landmarks may say where the robot is."""
        return self.lost or self.running or self._requested

    def request(self) -> None:
        """Ask for a search."""
        self._requested = True

    def begin(self, search: PoseSearch | None) -> None:
        """Begin the search that was asked for; None: there is nothing to search on."""
        self._search, self._requested = search, False

    def see(self, match: Match, grows: bool) -> bool:
        """Take a match on a map that ``grows`` or not. Returns whether it ended a search: the robot is where it was
        thought to be."""
        if grows:
            self._fits.see(match.stamp, match.inliers, match.matched, _SURE, _LEAST_MISFITS)
        else:
            self._fits.see(match.stamp, match.inliers, match.inliers >= FITS_NOT)
        if self._search is None or self._fits.lost:
            return False
        self.end()
        return True

    def search_needed(self, stamp: float) -> bool:
        """Whether scans have not fitted for so long at ``stamp`` (s) that a search is wanted, and none is asked for."""
        return not self._requested and self._fits.unfit_s(stamp) > self._search_after_s

    def suggest(self, X_MO: Pose2) -> None:
        """Take a pose by a landmark for the search's next step."""
        self._suggested.append(X_MO)

    def offer(self, scan: LaserScan, X_OB: Pose2) -> None:
        """Take the newest scan, with the body at ``X_OB``, for the search's next step."""
        self._scan = scan, X_OB

    def next_step(self) -> SearchStep | None:
        """What is to be run next; None without a search, or without a scan since the last step."""
        scan, self._scan = self._scan, None
        if self._search is None or scan is None:
            return None
        suggested = tuple(self._suggested)
        self._suggested.clear()
        return SearchStep(self._search, *scan, suggested)

    def belongs(self, step: SearchStep) -> bool:
        """Whether the search of ``step`` still goes on."""
        return step.search is self._search

    def take(self, hypotheses: tuple[PoseHypothesis, ...]) -> None:
        """Take the hypotheses of a step."""
        self._hypotheses = hypotheses

    def localization(self, stamp: float, X_OB: Pose2, last: Pose2, grid: OccupancyGrid | None) -> Localization:
        """That the robot is searched for, with the likeliest hypothesis, or ``last`` (X_MO) without any.

        The covariance is the spread of the hypotheses, without any the extent of ``grid``.
        """
        best = self._hypotheses[0] if self._hypotheses else None
        X_MO = last if best is None else best.X_MO
        overlap = 0.0 if best is None else max(0.0, best.score)
        covariance = spread_of([place.X_MO @ X_OB for place in self._hypotheses], grid)
        return Localization(
            stamp, X_MO, X_MB=X_MO @ X_OB, covariance=covariance, state="searching", overlap=overlap, map=""
        )
