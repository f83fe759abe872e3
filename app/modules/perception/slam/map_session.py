"""A map in use: localization scan by scan in one thread, drawing and searching in another.

Each method belongs to one thread: *ahead* (scan by scan, fast) or *behind* (drawing, searching; slow). The threads
share only frozen values.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.maps.library import GRAPH, MapLibrary
from app.maps.map_service import MapUnavailable
from app.messages import LaserScan, OccupancyGrid, Zone, read_only
from app.modules.perception.slam.beam_cache import BeamCache
from app.modules.perception.slam.grid_views import state_of
from app.modules.perception.slam.keyframe_view import NO_KEYFRAMES, KeyframeView, Removed, keyframe_view
from app.modules.perception.slam.likelihood_field import LikelihoodField
from app.modules.perception.slam.localization_quality import FITS
from app.modules.perception.slam.loop_closure import LoopJob, LoopOutcome
from app.modules.perception.slam.map_rendering import GLANCES, ExtraView, MapRenderer
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.occupancy import OccupancyCounts, cropped, view_of
from app.modules.perception.slam.pose_graph import Optimize, optimized
from app.modules.perception.slam.relocalization import PoseSearch
from app.modules.perception.slam.storage import read_state, write_state
from app.modules.perception.slam.types import Keyframe, Match, SlamState

#: Time (s) without a view from a keyframe after which an extra one is taken.
GLANCE_S = 1.0
#: Share of rays that differ by this length (m) when an object moved.
MOVED_SHARE, MOVED_M = 0.015, 0.25
#: Step (m) and speed (m/s) of odometry that mean a restart of odometry.
LEAP_M, LEAP_MPS = 2.0, 10.0
#: Number of keyframes drawn per turn.
_DRAWN_AT_ONCE = 50


@dataclass(frozen=True, slots=True, eq=False)
class StoredMap:
    """A map as saved; ``state`` is None for a map of another program."""

    name: str
    grid: OccupancyGrid
    zones: tuple[Zone, ...]
    state: SlamState | None


def stored_map(library: MapLibrary, name: str) -> StoredMap:
    """The map ``name``. Raises MapUnavailable, in words, where there is none or its files are damaged."""
    try:
        folder = library.existing(name)
        grid, zones = library.grid(name), library.zones(name)
        state = read_state(folder / GRAPH) if (folder / GRAPH).is_file() else None
    except (ValueError, ConfigError) as mistake:
        raise MapUnavailable(str(mistake)) from None
    except OSError as failure:
        raise MapUnavailable(f"the map {name!r} cannot be read: {failure.strerror or failure}") from None
    return StoredMap(name, grid, zones, state)


@dataclass(frozen=True, slots=True, eq=False)
class GraphSnapshot:
    """The keyframes and their poses at one moment."""

    keyframes: Mapping[int, Keyframe]
    poses: Mapping[int, Pose2]


@dataclass(frozen=True, slots=True, eq=False)
class ScanResult:
    """Result of one scan: the match, a job for the other thread, an extra view to draw, and the map's version.

    ``slam``: the mapper that matched it, to which the job's outcome belongs. ``keyframes``: the graph with which the
    match is consistent; ``removed``: keyframes pruned since the scan before.
    """

    match: Match
    job: LoopJob | None
    extra_view: ExtraView | None
    slam: Slam
    version: int
    keyframes: KeyframeView
    removed: tuple[Removed, ...]


class MapSession:
    """The map in use and the robot on it. ``grows``: whether it is to grow; ``extendable``: whether it can."""

    def __init__(
        self,
        grid: OccupancyGrid | None = None,
        state: SlamState | None = None,
        *,
        grows: bool = True,
        X_MO: Pose2 | None = None,
        cell_m: float = 0.05,
        side_m: float = 50.0,
        optimize: Optimize = optimized,
    ) -> None:
        """*Behind.* An empty map around the robot, or a saved one.

        ``grid``: the saved grid, with ``state`` if available. ``X_MO``: the robot's place on it; None: unknown.
        ``optimize``: function that corrects the graph.
        """
        self._optimize = optimize
        self.grows = grows
        self.extendable = grid is None or state is not None
        #: The cells as drawn last; the saved ones of a map that does not grow.
        self.grid = grid
        self._state = state_of(grid) if grid is not None and state is None else state
        self._slam: Slam | None = None
        self._frozen = False
        #: Initial pose of the localization; on an empty map, odometry's pose.
        self._X_MO = X_MO
        #: Stamp of the last used scan, odometry's pose then, and the covariance.
        self._last: tuple[float, Pose2, NDArray[np.float64]] | None = None
        #: The pose is unknown.
        self.lost = X_MO is None and grid is not None
        self._drawing = MapRenderer(OccupancyCounts(cell_m, side_m)) if grows else None
        #: Stamp and scan of the last extra view, and the number of views since an object moved.
        self._glanced = -math.inf
        self._looked_at: tuple[int, NDArray[np.float32]] | None = None
        self._quiet = 0
        self._beams = BeamCache()
        #: The newest arrays of the keyframes, of which mapper and version.
        self._view: tuple[Slam, int, KeyframeView] | None = None

    # --- Ahead -----------------------------------------------------------------------------------------------------

    def follow(
        self, scan: LaserScan, X_OB: Pose2, twist: tuple[float, float, float], maps: bool = True, rays: int = 1
    ) -> ScanResult | None:
        """*Ahead.* Take every ``rays``-th ray of a scan, with the body at ``X_OB`` and moving with ``twist``.

        ``maps``: whether the map may grow now. None while the pose is unknown.
        """
        if rays > 1:
            thin = read_only(scan.ranges[::rays].copy()), read_only(scan.intensities[::rays].copy())
            increment = rays * scan.angle_increment
            scan = replace(scan, ranges=thin[0], intensities=thin[1], angle_increment=increment)
        slam = self._slam
        frozen = not (self.grows and maps)
        if self._last is not None and slam is not None and self._X_MO is None and not self.lost:
            before, X_OB_before, _ = self._last
            if _leapt(X_OB_before.inverse() @ X_OB, scan.stamp - before):
                # Odometry restarted; the robot did not move.
                self._X_MO = slam.X_MO @ X_OB_before @ X_OB.inverse()
        if self._X_MO is not None:
            slam = self._follow_from(self._X_MO @ X_OB, frozen)
        elif self.lost:
            return None
        elif slam is None:
            slam = self._follow_from(Pose2(), frozen=False)
        elif frozen != self._frozen and slam.keyframes:
            slam = self._follow_from(slam.X_MO @ X_OB, frozen, None if self._last is None else self._last[2])
        match = slam.add(
            scan.stamp, scan.ranges, beams=self._beams(scan), X_OB=X_OB, twist=twist, sweep_s=scan.duration_s
        )
        self._last = scan.stamp, X_OB, match.covariance
        job = None if self._frozen else slam.pending()
        extra_view = None if self._frozen else self._extra_view(scan, match)
        removed = tuple(slam.take_removed())
        return ScanResult(match, job, extra_view, slam, slam.version, keyframes=self._keyframes(slam), removed=removed)

    def place(self, X_MO: Pose2) -> None:
        """*Ahead.* Set the approximate pose by ``X_MO``."""
        self._X_MO, self.lost = X_MO, False

    def lose(self) -> None:
        """*Ahead.* Mark the pose as unknown."""
        self._X_MO, self.lost = None, True

    def take(self, slam: Slam, outcome: LoopOutcome) -> None:
        """*Ahead.* Apply the outcome of a job of ``slam``, if that mapper is still in use."""
        if slam is self._slam:
            slam.take(outcome)

    def settling(self) -> tuple[Slam, LoopJob] | None:
        """*Ahead.* The final correction before saving, if there is one."""
        job = None if self._slam is None or self._frozen else self._slam.settling()
        return None if job is None or self._slam is None else (self._slam, job)

    def snapshot(self) -> GraphSnapshot:
        """*Ahead.* The data to draw."""
        if self._slam is None:
            return GraphSnapshot({}, {})
        ids, poses = self._slam.poses()
        placed = {int(id): Pose2(*pose) for id, pose in zip(ids, poses.tolist(), strict=True)}
        return GraphSnapshot(dict(self._slam.keyframes), placed)

    def state(self) -> SlamState | None:
        """*Ahead.* The state needed to resume mapping; None for a map that cannot grow."""
        if not self.extendable:
            return None
        return self._state if self._slam is None else self._slam.state()

    def keyframes(self) -> KeyframeView:
        """*Ahead.* The keyframes of a map that no scan was matched on yet."""
        state = self._state
        if state is None or not self.extendable:
            return NO_KEYFRAMES
        by_id = {keyframe.id: keyframe for keyframe in state.keyframes}
        return keyframe_view(by_id, dict(zip(by_id, state.poses, strict=True)))

    def _keyframes(self, slam: Slam) -> KeyframeView:
        """The same arrays as long as nothing changes."""
        if not self.extendable:
            return NO_KEYFRAMES
        if self._view is None or self._view[:2] != (slam, slam.version):
            self._view = slam, slam.version, slam.view()
        return self._view[2]

    def _follow_from(self, X_MB: Pose2, frozen: bool, covariance: NDArray[np.float64] | None = None) -> Slam:
        state = self._state if self._slam is None else self._slam.state()
        slam = Slam(state=state, X_MB=X_MB, frozen=frozen, optimize=self._optimize, covariance=covariance)
        self._slam, self._frozen, self._X_MO = slam, frozen, None
        return slam

    def _extra_view(self, scan: LaserScan, match: Match) -> ExtraView | None:
        """An extra view, if the last one is old enough and an object moved recently."""
        if match.added:
            self._glanced = scan.stamp
        if scan.stamp - self._glanced < GLANCE_S or match.inliers < FITS:
            return None
        self._glanced = scan.stamp
        before, self._looked_at = self._looked_at, (match.keyframe, scan.ranges)
        if before is None or before[0] != match.keyframe or differ(before[1], scan.ranges):
            self._quiet = 0
        self._quiet += 1
        return ExtraView(match.keyframe, match.X_KB, view_of(scan)) if self._quiet <= GLANCES else None

    # --- Behind ----------------------------------------------------------------------------------------------------

    def draw(self, snapshot: GraphSnapshot) -> bool:
        """*Behind.* Draw some new, removed or moved keyframes; returns whether more are left."""
        return self._drawing is not None and self._drawing.update(snapshot.keyframes, snapshot.poses, _DRAWN_AT_ONCE)

    def drawn(self, glances: Sequence[ExtraView], stamp: float, version: int) -> OccupancyGrid | None:
        """*Behind.* The grid as drawn, with extra views, if any of its cells changed since the last call."""
        if self._drawing is None:
            return None
        for extra_view in glances:
            self._drawing.extra_view(extra_view)
        counts = self._drawing.counts
        if not counts.refresh():
            return None
        cells = read_only(counts.cells.copy())
        self.grid = OccupancyGrid(
            stamp, "map", cells=cells, resolution_m=counts.resolution_m, origin=counts.origin, version=version
        )
        return self.grid

    def begin_search(self) -> PoseSearch | None:
        """*Behind.* A search on the map as last drawn; None without any."""
        if self.grid is None or not (self.grid.cells >= 0).any():
            return None
        return PoseSearch(LikelihoodField(self.grid))


def _leapt(step: Pose2, seconds: float) -> bool:
    """Whether odometry jumped further than a body can move."""
    return math.hypot(step.x, step.y) > LEAP_M + LEAP_MPS * max(0.0, seconds)


def differ(before: NDArray[np.float32], now: NDArray[np.float32]) -> bool:
    """Whether two scans from the same place show a moved object: differences beyond noise at edges."""
    if before.shape != now.shape:
        return True
    with np.errstate(invalid="ignore"):
        off = np.abs(before - now) > MOVED_M
    return bool(np.count_nonzero(off) > MOVED_SHARE * len(now))


def keep(
    library: MapLibrary,
    name: str,
    grid: OccupancyGrid,
    zones: tuple[Zone, ...],
    state: SlamState | None,
    others: Mapping[str, Callable[[Path], None]],
    former: str,
) -> None:
    """*Behind.* Save a map, with ``others`` as in ``MapLibrary.keep``. Raises MapUnavailable, in words, on failure."""
    rows, columns = cropped(grid.cells)
    origin = (
        grid.origin[0] + columns.start * grid.resolution_m,
        grid.origin[1] + rows.start * grid.resolution_m,
    )
    last_published = OccupancyGrid(
        grid.stamp,
        "map",
        cells=grid.cells[rows, columns],
        resolution_m=grid.resolution_m,
        origin=origin,
        version=grid.version,
    )

    def write_graph(path: Path) -> None:
        assert state is not None
        write_state(path, state)
        with path.open("rb") as file:
            os.fsync(file.fileno())

    try:
        library.keep(name, last_published, zones, {**others, **({} if state is None else {GRAPH: write_graph})}, former)
    except OSError as failure:
        raise MapUnavailable(f"the disk refuses the map {name!r}: {failure.strerror or failure}") from None
