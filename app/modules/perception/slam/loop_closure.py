"""Loop closure, off the critical path: search for loops of new keyframes, and correction of the graph."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.modules.perception.slam.correlative_matching import Pyramid, sought
from app.modules.perception.slam.drift_bound import DriftGraph
from app.modules.perception.slam.pose_graph import Optimize, graph_arrays
from app.modules.perception.slam.pruning import Pruned, pruned, redundant
from app.modules.perception.slam.scan_matching import NOISE_M, ScanFit, fitted
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from app.modules.perception.slam.types import Edge, Keyframe, Submap

_LEVELS = 6
#: Number of cached grids of old submaps, to bound memory.
_KEPT_GRIDS = 24
#: Prior (m, rad) of a loop's pose after the search: wide, so that the scan alone determines it along each axis.
_FREE_SIGMAS = (1.0, 1.0)
_LEAST_POINTS = 30
#: Greatest number of searched submaps per keyframe.
_MOST_CANDIDATES = 3
#: Keyframes after a closed loop before its submap is searched again.
_REST_KEYFRAMES = 4
#: A wide search is expensive: one per submap in this many keyframes.
_WIDE_EVERY = 4
#: Range of the laser beyond a keyframe (m).
_SEEN_FROM_M = 2.0
#: Greatest distance of the refined loop from the search's result (m), and greatest residual (m).
_REFINED_M = 0.3
_RMS_M = 0.04
#: Along a corridor the scan may slide: least information in the weaker direction, as a share of the stronger, and in
#: readings.
_SQUARENESS = 0.04
_LEAST_ACROSS = 3.0
#: A loop's error (m and rad, weighted) from which the graph is corrected at once, and number of keyframes after which
#: it is corrected anyway.
_WRONG_M = 0.12
_WRONG_PER_RAD = 2.0
_AFTER_KEYFRAMES = 60
#: Least numbers of keyframes between corrections, as shares of all keyframes, with such an error and without:
#: corrections of a larger graph take longer, so that their total grows linearly with the distance.
_KEYFRAMES_A_KEYFRAME = 200
_KEYFRAMES_A_KEYFRAME_UNLESS = 40
#: Period (keyframes) of the search for redundant keyframes.
_PRUNE_EVERY = 16
#: Angular window of the search (rad), and its increase per metre of the window.
_TURN_RAD = 0.25
_TURN_RAD_PER_M = 0.1
_TURN_MOST_RAD = 0.8
#: Displacement (m) of the robot by a loop from which two other consistent loops are required.
_FAR_WRONG_M = 2.0
_MOST_HELD = 24
#: Tolerance (m, rad) within which two loops are consistent.
_ALIKE_M = 0.4
_ALIKE_RAD = 0.08


@dataclass(frozen=True, slots=True)
class _Held:
    """A loop not accepted yet; ``X_MM``: its displacement of the robot on the map."""

    edge: Edge
    X_MM: Pose2
    needed: int


@dataclass(slots=True)
class LoopMemory:
    """State between searches; used by one job at a time."""

    grids: OrderedDict[int, tuple[SurfelGrid, Pyramid]] = field(default_factory=OrderedDict)
    closed_at: dict[int, int] = field(default_factory=dict)
    wide_at: dict[int, int] = field(default_factory=dict)
    drift: DriftGraph = field(default_factory=DriftGraph)
    held: list[_Held] = field(default_factory=list)
    optimized_at: int = 0
    pruned_at: int = 0
    wrong_m: float = 0.0
    unsettled: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class LoopOutcome:
    """Result of a job: ``edges`` to add; ``poses`` of all keyframes known to the job, None without correction.

    ``last``: the newest of these keyframes; later ones move along with it. ``pruned``: the graph without redundant
    keyframes, ``edges`` included, None if there are none.
    """

    edges: tuple[Edge, ...]
    poses: Mapping[int, Pose2] | None
    last: int
    pruned: Pruned | None


@dataclass(frozen=True, slots=True, eq=False)
class LoopJob:
    """The search for loops of the keyframes ``due``, and the correction of the graph: pure except for ``memory``.

    Keyframes ``in_use`` are not removed.
    """

    settings: SlamSettings
    keyframes: Mapping[int, Keyframe]
    poses: dict[int, Pose2]
    edges: tuple[Edge, ...]
    submaps: tuple[Submap, ...]
    due: tuple[int, ...]
    in_use: frozenset[int]
    memory: LoopMemory
    optimize: Optimize
    settle: bool = False

    def run(self) -> LoopOutcome:
        """Run the job once, in any thread."""
        found: list[Edge] = []
        for id in self.due:
            found += self._loops_of(id)
        memory = self.memory
        newest = next(reversed(self.poses))
        edges = [*self.edges, *found]
        cut = self._pruned(edges, newest)
        if cut is not None:
            edges = list(cut.edges)
        memory.unsettled += len(found)
        poses = None
        since = newest - memory.optimized_at
        due = since > max(_AFTER_KEYFRAMES, len(self.poses) / _KEYFRAMES_A_KEYFRAME_UNLESS) or (
            memory.wrong_m > _WRONG_M and since * _KEYFRAMES_A_KEYFRAME >= len(self.poses)
        )
        if memory.unsettled and (self.settle or due):
            left = {id: pose for id, pose in self.poses.items() if cut is None or id not in cut.replaced}
            poses = self._corrected(left, edges)
            memory.optimized_at = newest
            memory.wrong_m = 0.0
            memory.unsettled = 0
        return LoopOutcome(tuple(found), poses, newest, cut)

    def _pruned(self, edges: list[Edge], newest: int) -> Pruned | None:
        settings, memory = self.settings, self.memory
        if newest - memory.pruned_at < _PRUNE_EVERY:
            return None
        memory.pruned_at = newest
        recent = newest - 4 * settings.submap_keyframes
        kept = {id for id in self.poses if id > recent} | self.in_use | {next(iter(self.poses))}
        too_many = redundant(self.poses, kept, settings.keyframes_per_m2, settings.heading_sectors)
        if not too_many:
            return None
        cut = pruned(too_many, edges, self.submaps)
        for id in cut.changed:
            memory.grids.pop(id, None)
        memory.held = [held for held in memory.held if not {held.edge.a, held.edge.b} & cut.replaced.keys()]
        memory.drift.clear()
        return cut

    def _corrected(self, poses: Mapping[int, Pose2], edges: list[Edge]) -> Mapping[int, Pose2]:
        found = self.optimize(graph_arrays(poses, edges, self.memory.optimized_at))
        return {id: Pose2(float(x), float(y), float(theta)) for id, (x, y, theta) in zip(poses, found, strict=True)}

    def _loops_of(self, id: int) -> list[Edge]:
        keyframe, X_MK = self.keyframes[id], self.poses[id]
        if len(keyframe.points) < _LEAST_POINTS:
            return []
        edges: list[Edge] = []
        for submap, window_m in self._candidates(id):
            X_MS = self.poses[submap.keyframes[0]]
            guess = X_MS.inverse() @ X_MK
            fit = self._found(submap, keyframe, guess, window_m)
            if fit is None:
                continue
            X_MB = X_MS @ fit.X_SB
            nearest = min(submap.keyframes, key=lambda k: _distance(self.poses[k], X_MB))
            X_ab = self.poses[nearest].inverse() @ X_MB
            edge = Edge(nearest, id, X_ab, fit.edge_information(_FREE_SIGMAS), loop=True)
            believed = self._believed(edge, X_MK, X_MB)
            if believed:
                self.memory.closed_at[submap.id] = id
            edges += believed
        return edges

    def _found(self, submap: Submap, keyframe: Keyframe, guess: Pose2, window_m: float) -> ScanFit | None:
        """Match of the keyframe on ``submap``: near ``guess`` first, then farther, since similar places are
        frequent."""
        grid, pyramid = self._grid(submap)
        base = self.settings.loop_window_m
        windows = [min(base, window_m)]
        if window_m > 1.5 * base and keyframe.id - self.memory.wide_at.get(submap.id, -99) >= _WIDE_EVERY:
            windows.append(window_m)
            self.memory.wide_at[submap.id] = keyframe.id
        for window in windows:
            window_rad = min(_TURN_RAD + _TURN_RAD_PER_M * (window - base), _TURN_MOST_RAD)
            start = sought(
                pyramid,
                keyframe.points,
                guess=guess,
                window_m=window,
                window_rad=window_rad,
                threshold=self.settings.loop_score,
            )
            if start is None:
                continue
            fit = fitted(grid, keyframe.points, start[0], start[0], _FREE_SIGMAS, iterations=20, near_m=0.1)
            if self._convincing(fit, start[0]):
                return fit
        return None

    def _believed(self, edge: Edge, X_MK: Pose2, X_MB: Pose2) -> list[Edge]:
        """The edges to add for this loop: none while its displacement is large and too few others are consistent with
        it."""
        off = X_MK.inverse() @ X_MB
        wrong = math.hypot(off.x, off.y) + _WRONG_PER_RAD * abs(off.theta)
        held = self.memory.held
        alike: list[_Held] = []
        if wrong > self.settings.loop_alone_m:
            X_MM = X_MB @ X_MK.inverse()
            new = _Held(edge, X_MM, 2 if wrong < _FAR_WRONG_M else 3)
            alike = [other for other in held if _alike(other.X_MM @ X_MK, X_MB)]
            if len({other.edge.b for other in alike} | {edge.b}) < new.needed:
                held.append(new)
                del held[:-_MOST_HELD]
                return []
            self.memory.held = [other for other in held if other not in alike]
        self.memory.wrong_m = max(self.memory.wrong_m, wrong)
        return [*(other.edge for other in alike), edge]

    def _convincing(self, fit: ScanFit, start: Pose2) -> bool:
        refined = math.hypot(fit.X_SB.x - start.x, fit.X_SB.y - start.y)
        if fit.inliers < self.settings.loop_inliers or fit.rms_m > _RMS_M or refined > _REFINED_M:
            return False
        low, high = np.linalg.eigvalsh(fit.information[:2, :2])
        return bool(low >= _SQUARENESS * high and low * NOISE_M**2 >= _LEAST_ACROSS)

    def _candidates(self, id: int) -> list[tuple[Submap, float]]:
        """Old submaps that may overlap with keyframe ``id``, nearest first, with the search radius (m)."""
        settings, memory = self.settings, self.memory
        X_MK = self.poses[id]
        away_m = memory.drift.away_m(self.submaps, self.keyframes, self.edges, id)
        near: list[tuple[float, Submap, float]] = []
        for submap, drift_m in zip(self.submaps, away_m.tolist(), strict=True):
            last = submap.keyframes[-1]
            if last > id - 2 * settings.submap_keyframes or id - memory.closed_at.get(submap.id, -99) < _REST_KEYFRAMES:
                continue
            window = min(settings.loop_window_m + settings.loop_window_m_per_m * drift_m, settings.loop_window_max_m)
            away = min(_distance(self.poses[k], X_MK) for k in submap.keyframes[::3])
            if away <= _SEEN_FROM_M + window:
                near.append((away, submap, window))
        near.sort(key=lambda candidate: candidate[0])
        return [(submap, window) for _, submap, window in near[:_MOST_CANDIDATES]]

    def _grid(self, submap: Submap) -> tuple[SurfelGrid, Pyramid]:
        grids = self.memory.grids
        if submap.id in grids:
            grids.move_to_end(submap.id)
            return grids[submap.id]
        X_SM = self.poses[submap.keyframes[0]].inverse()
        grid = surfel_grid((self.keyframes[k].points, X_SM @ self.poses[k]) for k in submap.keyframes)
        grids[submap.id] = grid, Pyramid(grid, _LEVELS)
        if len(grids) > _KEPT_GRIDS:
            grids.popitem(last=False)
        return grids[submap.id]


def _distance(a: Pose2, b: Pose2) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def _alike(a: Pose2, b: Pose2) -> bool:
    return _distance(a, b) < _ALIKE_M and abs(wrap_angle(a.theta - b.theta)) < _ALIKE_RAD


def pose_array(poses: Mapping[int, Pose2]) -> NDArray[np.float64]:
    """(N, 3) x, y, theta."""
    return np.array([(p.x, p.y, p.theta) for p in poses.values()], dtype=np.float64).reshape(-1, 3)
