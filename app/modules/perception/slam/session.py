"""A map in use: followed scan by scan in one thread, worked on behind in another.

Methods say which thread they belong to: *ahead* (scan by scan, quick) or *behind* (drawing, searching: what may take
long). The two share nothing but frozen values.
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
from app.maps.control import MapUnavailable
from app.maps.library import GRAPH, MapLibrary
from app.messages import LaserScan, OccupancyGrid, Zone, read_only
from app.modules.perception.slam.beams import BeamsOf
from app.modules.perception.slam.grid_views import state_of
from app.modules.perception.slam.likelihood_field import PlaceField
from app.modules.perception.slam.localization_quality import FITS
from app.modules.perception.slam.loop_closure import LoopJob, LoopOutcome
from app.modules.perception.slam.map_rendering import GLANCES, Glance, MapDrawing
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.occupancy import OccupancyCounts, cropped, view_of
from app.modules.perception.slam.pose_graph import Optimize, optimized
from app.modules.perception.slam.relocalization import Place, PlaceSearch, Sighting
from app.modules.perception.slam.storage import read_state, write_state
from app.modules.perception.slam.types import Keyframe, Match, SlamState

#: One more look is taken from a keyframe when no other was made for so long (s).
GLANCE_S = 1.0
#: Something moved where more than this share of the rays are longer or shorter by this (m).
MOVED_SHARE, MOVED_M = 0.015, 0.25
#: Odometry that goes farther than this (m), and faster (m/s), has begun anew.
LEAP_M, LEAP_MPS = 2.0, 10.0
#: Keyframes drawn before other work has its turn.
_DRAWN_AT_ONCE = 50


@dataclass(frozen=True, slots=True, eq=False)
class KeptMap:
    """A map as it was kept; ``state`` is None for one that another program made."""

    name: str
    grid: OccupancyGrid
    zones: tuple[Zone, ...]
    state: SlamState | None


def kept_map(library: MapLibrary, name: str) -> KeptMap:
    """The map ``name``. Raises MapUnavailable, in words, where there is none or its files are damaged."""
    try:
        folder = library.existing(name)
        grid, zones = library.grid(name), library.zones(name)
        state = read_state(folder / GRAPH) if (folder / GRAPH).is_file() else None
    except (ValueError, ConfigError) as mistake:
        raise MapUnavailable(str(mistake)) from None
    except OSError as failure:
        raise MapUnavailable(f"the map {name!r} cannot be read: {failure.strerror or failure}") from None
    return KeptMap(name, grid, zones, state)


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The keyframes and where they are, as of one moment."""

    keyframes: Mapping[int, Keyframe]
    poses: Mapping[int, Pose2]


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What came of one scan: the match, work that is due behind, one more look to draw, and the map's version after.

    ``slam`` is who matched it: the job's outcome is for that one.
    """

    match: Match
    job: LoopJob | None
    glance: Glance | None
    slam: Slam
    version: int


class MapSession:
    """The map in use and the robot on it. ``grows``: whether it is meant to; ``extendable``: whether it could."""

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
        """*Behind.* An empty map, which begins around the robot, or one that was kept.

        That is ``grid``, with ``state`` where it has one. ``X_MO`` says where the robot is on it; None: nobody knows.
        ``optimize`` corrects the graph.
        """
        self._optimize = optimize
        self.grows = grows
        self.extendable = grid is None or state is not None
        #: The cells as drawn last; those that were kept, of a map that stays.
        self.grid = grid
        self._state = state_of(grid) if grid is not None and state is None else state
        self._slam: Slam | None = None
        self._frozen = False
        #: The robot is to be followed from here; on an empty map, wherever odometry says it is.
        self._X_MO = X_MO
        #: When a scan was followed last, where odometry had the body then, and how sure its place was.
        self._last: tuple[float, Pose2, NDArray[np.float64]] | None = None
        #: Nobody knows where the robot is.
        self.lost = X_MO is None and grid is not None
        self._drawing = MapDrawing(OccupancyCounts(cell_m, side_m)) if grows else None
        #: When a look was taken last, at what, and how many since something moved.
        self._glanced = -math.inf
        self._looked_at: tuple[int, NDArray[np.float32]] | None = None
        self._quiet = 0
        self._beams = BeamsOf()

    # --- Ahead -----------------------------------------------------------------------------------------------------

    def follow(
        self, scan: LaserScan, X_OB: Pose2, twist: tuple[float, float], maps: bool = True, rays: int = 1
    ) -> Followed | None:
        """*Ahead.* Take one in ``rays`` of a scan's rays, the body being at ``X_OB`` and moving with ``twist``.

        ``maps`` says whether the map may grow now. None while the robot's place is unknown.
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
                # Odometry began anew; the robot did not move.
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
        glance = None if self._frozen else self._glance(scan, match)
        return Followed(match, job, glance, slam, slam.version)

    def place(self, X_MO: Pose2) -> None:
        """*Ahead.* The robot is about where this ``X_MO`` has it."""
        self._X_MO, self.lost = X_MO, False

    def lose(self) -> None:
        """*Ahead.* Nobody knows any more where the robot is."""
        self._X_MO, self.lost = None, True

    def take(self, slam: Slam, outcome: LoopOutcome) -> None:
        """*Ahead.* Take over what a job of ``slam`` found, if the robot is still followed by that."""
        if slam is self._slam:
            slam.take(outcome)

    def settling(self) -> tuple[Slam, LoopJob] | None:
        """*Ahead.* The last correction before the map is kept, if there is one."""
        job = None if self._slam is None or self._frozen else self._slam.settling()
        return None if job is None or self._slam is None else (self._slam, job)

    def snapshot(self) -> Snapshot:
        """*Ahead.* What there is to draw."""
        if self._slam is None:
            return Snapshot({}, {})
        ids, poses = self._slam.poses()
        placed = {int(id): Pose2(*pose) for id, pose in zip(ids, poses.tolist(), strict=True)}
        return Snapshot(dict(self._slam.keyframes), placed)

    def state(self) -> SlamState | None:
        """*Ahead.* What must be kept so that mapping can go on; None for a map that cannot grow."""
        if not self.extendable:
            return None
        return self._state if self._slam is None else self._slam.state()

    def _follow_from(self, X_MB: Pose2, frozen: bool, covariance: NDArray[np.float64] | None = None) -> Slam:
        state = self._state if self._slam is None else self._slam.state()
        slam = Slam(state=state, X_MB=X_MB, frozen=frozen, optimize=self._optimize, covariance=covariance)
        self._slam, self._frozen, self._X_MO = slam, frozen, None
        return slam

    def _glance(self, scan: LaserScan, match: Match) -> Glance | None:
        """One more look, if none was taken for a while and something moved not long ago."""
        if match.added:
            self._glanced = scan.stamp
        if scan.stamp - self._glanced < GLANCE_S or match.inliers < FITS:
            return None
        self._glanced = scan.stamp
        before, self._looked_at = self._looked_at, (match.keyframe, scan.ranges)
        if before is None or before[0] != match.keyframe or differ(before[1], scan.ranges):
            self._quiet = 0
        self._quiet += 1
        return Glance(match.keyframe, match.X_KB, view_of(scan)) if self._quiet <= GLANCES else None

    # --- Behind ----------------------------------------------------------------------------------------------------

    def draw(self, snapshot: Snapshot) -> bool:
        """*Behind.* Draw some of what is new, gone or elsewhere; returns whether more is left."""
        return self._drawing is not None and self._drawing.update(snapshot.keyframes, snapshot.poses, _DRAWN_AT_ONCE)

    def drawn(self, glances: Sequence[Glance], stamp: float, version: int) -> OccupancyGrid | None:
        """*Behind.* The grid as drawn, ``glances`` too, if any of its cells changed since the last time."""
        if self._drawing is None:
            return None
        for glance in glances:
            self._drawing.glance(glance)
        counts = self._drawing.counts
        if not counts.refresh():
            return None
        cells = read_only(counts.cells.copy())
        self.grid = OccupancyGrid(
            stamp, "map", cells=cells, resolution_m=counts.resolution_m, origin=counts.origin, version=version
        )
        return self.grid

    def begin_search(self) -> PlaceSearch | None:
        """*Behind.* A search on the map as it was drawn last; None where there is nothing yet."""
        if self.grid is None or not (self.grid.cells >= 0).any():
            return None
        return PlaceSearch(PlaceField(self.grid))


def _leapt(step: Pose2, seconds: float) -> bool:
    """Whether odometry says what no body does."""
    return math.hypot(step.x, step.y) > LEAP_M + LEAP_MPS * max(0.0, seconds)


def differ(before: NDArray[np.float32], now: NDArray[np.float32]) -> bool:
    """Whether two scans from the same place show something that moved: more than what noise does at edges."""
    if before.shape != now.shape:
        return True
    with np.errstate(invalid="ignore"):
        off = np.abs(before - now) > MOVED_M
    return bool(np.count_nonzero(off) > MOVED_SHARE * len(now))


def look(search: PlaceSearch, scan: LaserScan, X_OB: Pose2) -> tuple[Pose2 | None, tuple[Place, ...]]:
    """*Behind.* Give ``search`` a scan: X_MO if the place is believed now, and all that are possible."""
    view = view_of(scan)
    points = view.ends[view.met].astype(np.float64)
    return search.see(Sighting(points, np.array(view.eye), X_OB)), search.places


def keep(
    library: MapLibrary,
    name: str,
    grid: OccupancyGrid,
    zones: tuple[Zone, ...],
    state: SlamState | None,
    others: Mapping[str, Callable[[Path], None]],
    former: str,
) -> None:
    """*Behind.* Keep a map, with ``others`` as in ``MapLibrary.keep``. Raises MapUnavailable, in words, where that
    cannot be."""
    rows, columns = cropped(grid.cells)
    origin = (
        grid.origin[0] + columns.start * grid.resolution_m,
        grid.origin[1] + rows.start * grid.resolution_m,
    )
    shown = OccupancyGrid(
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
        library.keep(name, shown, zones, {**others, **({} if state is None else {GRAPH: write_graph})}, former)
    except OSError as failure:
        raise MapUnavailable(f"the disk refuses the map {name!r}: {failure.strerror or failure}") from None
