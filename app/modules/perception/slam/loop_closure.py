"""Closing loops, off the critical path: where a new keyframe sees a place again, and what the graph says then."""

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
from app.modules.perception.slam.scan_matching import NOISE_M, Fit, fitted
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from app.modules.perception.slam.types import Edge, Keyframe, Submap

_LEVELS = 6
#: Grids of old submaps that are kept for the next search: bounds the memory.
_KEPT_GRIDS = 24
#: A search leaves a loop's pose free (m, rad): what its scan says of it, along which axis, is all that is known.
_FREE_SIGMAS = (1.0, 1.0)
_LEAST_POINTS = 30
#: Searching, so many submaps at most for one keyframe.
_MOST_CANDIDATES = 3
#: A submap is not looked at again for so many keyframes after it closed a loop.
_REST_KEYFRAMES = 4
#: Looking far around is dear: a submap is searched so for one in so many keyframes.
_WIDE_EVERY = 4
#: What the laser sees beyond its keyframe (m).
_SEEN_FROM_M = 2.0
#: A loop is refined no farther from where the search found it (m), and fits so well (m).
_REFINED_M = 0.3
_RMS_M = 0.04
#: Along a corridor the scan may slide: the weaker of both directions needs this share of the stronger, and so many
#: readings' worth.
_SQUARENESS = 0.04
_LEAST_ACROSS = 3.0
#: The graph is corrected when a loop says that it is so wrong (m and rad, weighted), or so many keyframes later.
_WRONG_M = 0.12
_WRONG_PER_RAD = 2.0
_AFTER_KEYFRAMES = 60
#: ... but no sooner than after one keyframe for so many that there are, if it is so wrong, or else: the larger the
#: graph, the longer it takes, so that all corrections together grow as the way does.
_KEYFRAMES_A_KEYFRAME = 200
_KEYFRAMES_A_KEYFRAME_UNLESS = 40
#: Keyframes that are too many are looked for so often (keyframes).
_PRUNE_EVERY = 16
#: How far the robot may be turned (rad), and how much more per metre that it may be off.
_TURN_RAD = 0.25
_TURN_RAD_PER_M = 0.1
_TURN_MOST_RAD = 0.8
#: A loop that would move the robot so far (m) needs two others that say the same.
_FAR_WRONG_M = 2.0
_MOST_HELD = 24
#: Two loops say the same if they put the robot so near (m, rad).
_ALIKE_M = 0.4
_ALIKE_RAD = 0.08


@dataclass(frozen=True, slots=True)
class _Held:
    """A loop that is not believed yet; ``X_MM`` is how it would move the robot on the map."""

    edge: Edge
    X_MM: Pose2
    needed: int


@dataclass(slots=True)
class LoopMemory:
    """What one search leaves for the next; used by one job at a time."""

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
    """What a job found: ``edges`` to be added; ``poses`` of all keyframes then known, None while the graph may stay.

    ``last`` is the newest keyframe the job knew of: later ones move along with it. ``pruned`` is what is left of the
    graph that the job knew, ``edges`` included, where some of it was too much.
    """

    edges: tuple[Edge, ...]
    poses: Mapping[int, Pose2] | None
    last: int
    pruned: Pruned | None


@dataclass(frozen=True, slots=True, eq=False)
class LoopJob:
    """The search for loops of the keyframes ``due``, and the graph's correction: pure but for ``memory``.

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
        """May be called in any thread, once."""
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
        memory.drift.forget()
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

    def _found(self, submap: Submap, keyframe: Keyframe, guess: Pose2, window_m: float) -> Fit | None:
        """Where ``submap`` shows what the keyframe shows: near ``guess`` before farther, where much looks alike."""
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
        """The edges to be added for this one: none while it would move much and not enough others say the same."""
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

    def _convincing(self, fit: Fit, start: Pose2) -> bool:
        refined = math.hypot(fit.X_SB.x - start.x, fit.X_SB.y - start.y)
        if fit.inliers < self.settings.loop_inliers or fit.rms_m > _RMS_M or refined > _REFINED_M:
            return False
        low, high = np.linalg.eigvalsh(fit.information[:2, :2])
        return bool(low >= _SQUARENESS * high and low * NOISE_M**2 >= _LEAST_ACROSS)

    def _candidates(self, id: int) -> list[tuple[Submap, float]]:
        """Old submaps that may see what keyframe ``id`` sees, the nearest first, and how far (m) to look around."""
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
