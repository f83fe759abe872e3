"""Slam: localization and mapping, scan by scan."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.modules.perception.slam.correlative_matching import sought
from app.modules.perception.slam.edges import edge_information
from app.modules.perception.slam.keyframe_view import KeyframeView, Removed, keyframe_view
from app.modules.perception.slam.local_map import DOUBTED_M, STALE_M, LocalMap, local_map
from app.modules.perception.slam.loop_closure import LoopJob, LoopMemory, LoopOutcome, pose_array
from app.modules.perception.slam.odometry_calibration import OdometryRatios
from app.modules.perception.slam.pose_estimate import PoseEstimate
from app.modules.perception.slam.pose_graph import Optimize, optimized
from app.modules.perception.slam.pruning import Pruned
from app.modules.perception.slam.scan_matching import ScanFit, fitted
from app.modules.perception.slam.scans import BeamGeometry, Scan, prepared
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.submap_builder import ActiveSubmap, SubmapBuilder
from app.modules.perception.slam.types import Edge, Keyframe, Match, SlamState

#: Motion (m, rad) below which odometry counts as standing, and number of scans after which a standing robot matches
#: again.
_REST = 1e-4
_REST_SCANS = 10
_LEAST_POINTS = 25
_RESCUE_SCORE = 0.45
#: Least advantage, in share of the scan, of another pose ...
_RESCUE_GAIN = 0.03
#: ... plus up to this, growing with its distance from odometry: most of it from about this many squared sigmas on.
_PRICE_MOST = 0.37
_PRICE_SIGMAS2 = 10.0
#: Metres added to the distance driven by a scan that does not fit: the drift grows faster then.
_POOR_SCAN_M = 3.0
#: Uncertainty (m, rad) of a pose set by a person or a search.
_PLACED_SIGMAS = (0.5, 0.25)
#: Greatest window (m, rad) of the rescue search.
_RESCUE_MOST = (6.0, math.pi)


class Slam:
    """Localizes the robot and, unless ``frozen``, maps. Not to be called from two threads at once.

    The map starts with the robot at ``X_MB``; with ``state``, it is a saved one, and the robot is about at ``X_MB`` on
    it, with ``covariance`` (as of :class:`Match`) if known. ``frozen``: the map and its memory stay unchanged.
    ``optimize``: function that corrects the graph.
    """

    def __init__(
        self,
        settings: SlamSettings | None = None,
        *,
        state: SlamState | None = None,
        X_MB: Pose2 | None = None,
        frozen: bool = False,
        optimize: Optimize = optimized,
        covariance: NDArray[np.float64] | None = None,
    ) -> None:
        self.settings = settings or SlamSettings()
        self._optimize = optimize
        self._frozen = frozen
        kept = state or SlamState((), (), (), ())
        self._keyframes = {keyframe.id: keyframe for keyframe in kept.keyframes}
        self._poses = dict(zip(self._keyframes, kept.poses, strict=True))
        self._edges = list(kept.edges)
        #: Number of closed loops.
        self.loops = sum(edge.loop for edge in kept.edges)
        self._submaps = SubmapBuilder(self.settings.submap_keyframes, kept.submaps)
        self._made = max(self._keyframes, default=-1) + 1
        self._memory = LoopMemory()
        self._due: list[int] = []
        self._job_out = False
        self._job_knew = (0, 0)
        #: Incremented whenever a keyframe is added, removed or moved.
        self.version = 0
        self._removed: list[Removed] = []
        self._moved = False
        self._travelled_m = max((keyframe.travelled_m for keyframe in kept.keyframes), default=0.0)
        self._estimate = PoseEstimate()
        self._X_OB: Pose2 | None = None
        self._keyframe = -1
        self._X_KB = Pose2()
        self._rested = 0
        self._last_fit: ScanFit | None = None
        self._off = (0.0, 0.0)
        self._step_sigmas = (0.0, 0.0)
        self._ratios = OdometryRatios()
        self._local: LocalMap | None = None
        self._placed = False
        self.place(X_MB or Pose2())
        if covariance is not None:
            self._estimate.covariance = covariance

    def place(self, X_MB: Pose2) -> None:
        """Set the approximate pose ``X_MB``: the next scan is searched around it."""
        self._estimate.X_MB = X_MB
        if not self._keyframes:
            self._estimate.covariance = np.zeros((3, 3))
            return
        sigma_m, sigma_rad = _PLACED_SIGMAS
        self._estimate.covariance = np.diag([sigma_m**2, sigma_m**2, sigma_rad**2])
        self._placed = True
        self._rested = _REST_SCANS
        self._submaps.finish()
        self._look_around()

    def add(
        self,
        stamp: float,
        ranges: NDArray[np.floating],
        beams: BeamGeometry,
        X_OB: Pose2,
        twist: tuple[float, float, float] = (0.0, 0.0, 0.0),
        sweep_s: float = 0.0,
    ) -> Match:
        """Take one sweep, started at ``stamp`` with the body at ``X_OB`` and moving with ``twist`` (m/s,
        rad/s, sideways m/s)."""
        step = self._X_OB.inverse() @ X_OB if self._X_OB is not None else Pose2()
        self._X_OB = X_OB
        if self._keyframes:
            distance = math.hypot(step.x, step.y)
            self._travelled_m += distance
            if distance < _REST and abs(step.theta) < _REST and self._rested < _REST_SCANS:
                self._rested += 1
                self._off = (0.0, 0.0)
                return self._published(stamp, X_OB, added=False)
        self._rested = 0
        scan = prepared(
            ranges,
            beams,
            twist=twist,
            sweep_s=sweep_s,
            range_max_m=self.settings.range_max_m,
            thinning_m=self.settings.thinning_m,
        )
        if not self._keyframes:
            if not len(scan.points):
                return self._published(stamp, X_OB, added=False)
            self._add_keyframe(stamp, scan, None)
            return self._published(stamp, X_OB, added=True)
        if self._frozen and self._local is not None:
            gone = self._local.X_MB.inverse() @ self._estimate.X_MB
            doubted = self._last_fit is not None and self._last_fit.inliers < self.settings.poor_below
            if math.hypot(gone.x, gone.y) > (DOUBTED_M if doubted else STALE_M):
                self._look_around()
        fit = self._follow(scan, step)
        off = self._poses[self._keyframe].inverse() @ self._estimate.X_MB
        added = self.settings.is_far(off, lost=fit.inliers < self.settings.lost_below) and not self._frozen
        if added:
            self._add_keyframe(stamp, scan, fit)
        else:
            self._X_KB = off
        return self._published(stamp, X_OB, added)

    def pending(self) -> LoopJob | None:
        """The next job (loop search, graph correction); None while one is running, or none is due."""
        if self._job_out or not self._due:
            return None
        due, self._due = tuple(self._due), []
        return self._job(due, settle=False)

    def settling(self) -> LoopJob | None:
        """The final correction of the graph: at the end of a log, or before saving a map."""
        return None if self._job_out or not self._poses else self._job((), settle=True)

    def take(self, outcome: LoopOutcome) -> None:
        """Apply the result of a job; fast."""
        self._job_out = False
        known_edges = self._job_knew[0]
        self._edges[known_edges:known_edges] = outcome.edges
        self._job_knew = known_edges + len(outcome.edges), self._job_knew[1]
        self.loops += len(outcome.edges)
        if outcome.pruned is not None:
            self._drop(outcome.pruned)
        if outcome.poses is None:
            return
        shift = outcome.poses[outcome.last] @ self._poses[outcome.last].inverse()
        for id, pose in self._poses.items():
            known = outcome.poses.get(id)
            if known is not None or id > outcome.last:
                self._poses[id] = known if known is not None else shift @ pose
        self._estimate.X_MB = self._poses[self._keyframe] @ self._X_KB
        self._moved = True
        self.version += 1

    @property
    def X_MO(self) -> Pose2:
        """Pose of ``odom`` on the map by the last scan, including corrections since."""
        return self._estimate.X_MB if self._X_OB is None else self._estimate.X_MB @ self._X_OB.inverse()

    @property
    def keyframes(self) -> Mapping[int, Keyframe]:
        """All keyframes by id, in the order of their making."""
        return MappingProxyType(self._keyframes)

    def pose(self, id: int) -> Pose2:
        """Pose of keyframe ``id`` on the map (``X_MK``)."""
        return self._poses[id]

    def poses(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Ids (N,) and poses (N, 3) x, y, theta on the map of all keyframes, in the order of ``keyframes``."""
        return np.array(list(self._poses), dtype=np.int64), pose_array(self._poses)

    def view(self) -> KeyframeView:
        """The keyframes and their poses as arrays."""
        return keyframe_view(self._keyframes, self._poses)

    def take_removed(self) -> list[Removed]:
        """The keyframes pruned since the last call, in that order."""
        removed, self._removed = self._removed, []
        return removed

    def state(self) -> SlamState:
        """The state needed to resume mapping."""
        active = (tuple(submap.keyframes) for submap in self._submaps.active) if not self._frozen else ()
        submaps = (*(submap.keyframes for submap in self._submaps.finished), *active)
        return SlamState(tuple(self._keyframes.values()), tuple(self._poses.values()), tuple(self._edges), submaps)

    def _drop(self, cut: Pruned) -> None:
        """Discard the job's result, unless the pose was set meanwhile."""
        if self._in_use() & cut.replaced.keys():
            return
        # Additions during the job follow the entries the job knew.
        known_edges, known_submaps = self._job_knew
        self._edges = [*cut.edges, *self._edges[known_edges:]]
        self._submaps.replace(cut.submaps, known_submaps)
        for id in cut.removed:
            del self._keyframes[id], self._poses[id]
        self._removed += [(id, *cut.replaced[id]) for id in cut.removed]
        self.version += 1

    def _in_use(self) -> frozenset[int]:
        return frozenset(id for submap in self._submaps.active for id in submap.keyframes) | {self._keyframe}

    # --- Localization -------------------------------------------------------------------------------------------------

    def _follow(self, scan: Scan, step: Pose2) -> ScanFit:
        """Predict by odometry's ``step``, then match the scan on the submap."""
        settings = self.settings
        step = self._ratios.corrected(step)
        distance = math.hypot(step.x, step.y)
        sigma_m, sigma_rad = settings.odometry_sigmas(distance, step.theta)
        if self._placed:
            sigma_m, sigma_rad = math.hypot(sigma_m, _PLACED_SIGMAS[0]), math.hypot(sigma_rad, _PLACED_SIGMAS[1])
        self._step_sigmas = sigma_m, sigma_rad
        self._estimate.predict(step, sigma_m, sigma_rad)
        submap = self._submaps.active[0]
        X_MS = self._poses[submap.first]
        prior = X_MS.inverse() @ self._estimate.X_MB
        fit = fitted(submap.grid, scan.points, prior, prior, (sigma_m, sigma_rad))
        if fit.inliers >= settings.rescue_below and not self._placed:
            self._ratios.learn(step, prior.inverse() @ fit.X_SB)
        if (fit.inliers < settings.rescue_below or self._placed) and len(scan.points) > _LEAST_POINTS:
            fit = self._rescued(submap, scan, prior=prior, fit=fit, sigmas=(sigma_m, sigma_rad), step=step)
        self._placed = self._placed and fit.inliers < settings.lost_below
        self._last_fit = fit
        if fit.inliers < settings.poor_below:
            self._travelled_m += _POOR_SCAN_M
        self._off = (0.0, 0.0)
        if fit.inliers >= settings.lost_below:
            off = prior.inverse() @ fit.X_SB
            self._off = math.hypot(off.x, off.y), abs(wrap_angle(off.theta))
            self._estimate.update(X_MS, fit)
        return fit

    def _rescued(
        self,
        submap: ActiveSubmap,
        scan: Scan,
        prior: Pose2,
        fit: ScanFit,
        sigmas: tuple[float, float],
        step: Pose2,
    ) -> ScanFit:
        """A better pose than ``fit`` from a wider search around ``prior``, if there is one."""
        # The uncertainty accumulated since scans fitted last widens the window.
        before = self._estimate.covariance_before
        window_m = 0.5 + math.hypot(step.x, step.y) + 2.0 * math.sqrt(before[:2, :2].trace())
        window_rad = 0.25 + abs(step.theta) + 2.0 * math.sqrt(before[2, 2])
        window_m, window_rad = min(window_m, _RESCUE_MOST[0]), min(window_rad, _RESCUE_MOST[1])
        found = sought(
            submap.pyramid(),
            scan.points,
            guess=prior,
            window_m=window_m,
            window_rad=window_rad,
            threshold=_RESCUE_SCORE,
        )
        if found is None:
            return fit
        loose = (sigmas[0] * math.sqrt(5.0), sigmas[1] * math.sqrt(5.0))
        other = fitted(submap.grid, scan.points, found[0], prior, loose)
        # A similar place one door further fits, too: the required advantage grows with the distance from odometry.
        X_MS = self._poses[submap.first]
        surcharge = self._price(X_MS @ other.X_SB) - self._price(X_MS @ fit.X_SB)
        return other if other.inliers > fit.inliers + _RESCUE_GAIN + surcharge else fit

    def _price(self, X_MB: Pose2) -> float:
        """Required advantage in share of the scan of a fit at ``X_MB``, by its distance from odometry.

        Bounded: wheel slip can lead anywhere.
        """
        return _PRICE_MOST * (1.0 - math.exp(-self._estimate.squared_sigmas(X_MB) / _PRICE_SIGMAS2))

    # --- Mapping ---------------------------------------------------------------------------------------------------

    def _add_keyframe(self, stamp: float, scan: Scan, fit: ScanFit | None) -> None:
        id = self._made
        self._made += 1
        self._keyframes[id] = Keyframe(
            id,
            stamp,
            points=scan.points,
            ends=scan.ends,
            hits=scan.hits,
            origin=scan.origin,
            travelled_m=self._travelled_m,
        )
        self._poses[id] = self._estimate.X_MB
        self._keyframe, self._X_KB = id, Pose2()
        self.version += 1
        information = edge_information(fit, self._step_sigmas, self._estimate.covariance, self.settings.lost_below)
        lost = fit is not None and fit.inliers < self.settings.lost_below
        for submap in self._submaps.active:
            X_SB = self._poses[submap.first].inverse() @ self._estimate.X_MB
            self._edges.append(Edge(submap.first, id, X_SB, information, loop=False))
            if not lost:
                submap.add(id, scan.points, X_SB)
        if lost:
            # Later scans are matched with this scan, not with earlier ones: the connection to these is odometry alone.
            self._submaps.finish()
        self._submaps.begin_if_due(id, scan.points)
        self._due.append(id)

    def _look_around(self) -> None:
        """Localize on the local map around the robot; new keyframes are attached to its nearest keyframe."""
        self._local = local = local_map(self._keyframes, self._poses, self._estimate.X_MB)
        self._submaps.begin_on(local.grid, local.nearest)
        self._keyframe = local.nearest
        self._X_KB = self._poses[local.nearest].inverse() @ self._estimate.X_MB

    def _job(self, due: tuple[int, ...], settle: bool) -> LoopJob:
        self._job_out = True
        self._job_knew = len(self._edges), len(self._submaps.finished)
        return LoopJob(
            self.settings,
            dict(self._keyframes),
            poses=dict(self._poses),
            edges=tuple(self._edges),
            submaps=tuple(self._submaps.finished),
            due=due,
            in_use=self._in_use(),
            memory=self._memory,
            optimize=self._optimize,
            settle=settle,
        )

    def _published(self, stamp: float, X_OB: Pose2, added: bool) -> Match:
        fit = self._last_fit
        moved, self._moved = self._moved, False
        return Match(
            stamp=stamp,
            X_MB=self._estimate.X_MB,
            X_MO=self._estimate.X_MB @ X_OB.inverse(),
            covariance=self._estimate.covariance,
            overlap=0.0 if fit is None else fit.overlap,
            inliers=0.0 if fit is None else fit.inliers,
            matched=fit is None or fit.inliers >= self.settings.lost_below,
            keyframe=self._keyframe,
            X_KB=self._X_KB,
            added=added,
            moved=moved,
            off=self._off,
        )
