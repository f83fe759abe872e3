"""Closing loops, off the critical path: where a new keyframe sees a place again, and what the graph says then."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.modules.perception.slam.matching import NOISE_M, Fit, fitted
from app.modules.perception.slam.pose_graph import Optimize, graph_arrays
from app.modules.perception.slam.search import Pyramid, sought
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from app.modules.perception.slam.values import Edge, Keyframe

_LEVELS = 6
#: Grids of old submaps that are kept for the next search: bounds the memory.
_KEPT_GRIDS = 24
#: Of a loop's edge (m, rad), seen by the whole scan.
_LOOP_SIGMAS = (0.03, 0.008)
_LEAST_POINTS = 30
#: Searching, so many submaps at most for one keyframe.
_MOST_CANDIDATES = 3
#: A submap is not looked at again for so many keyframes after it closed a loop.
_REST_KEYFRAMES = 4
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


@dataclass(frozen=True, slots=True)
class Submap:
    """Keyframes next to each other, by id, that are looked at together; the first gives the frame."""

    id: int
    keyframes: tuple[int, ...]


@dataclass(slots=True)
class LoopMemory:
    """What one search leaves for the next; used by one job at a time."""

    grids: OrderedDict[int, tuple[SurfelGrid, Pyramid]] = field(default_factory=OrderedDict)
    closed_at: dict[int, int] = field(default_factory=dict)
    last_loop_m: float = -math.inf
    optimized_at: int = 0
    wrong_m: float = 0.0
    unsettled: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class LoopOutcome:
    """What a job found: ``edges`` to be added; ``poses`` of all keyframes then known, None while the graph may stay.

    ``last`` is the newest keyframe the job knew of: later ones move along with it.
    """

    edges: tuple[Edge, ...]
    poses: Mapping[int, Pose2] | None
    last: int


@dataclass(frozen=True, slots=True, eq=False)
class LoopJob:
    """The search for loops of the keyframes ``due``, and the graph's correction: pure but for ``memory``."""

    settings: SlamSettings
    keyframes: Mapping[int, Keyframe]
    poses: dict[int, Pose2]
    edges: tuple[Edge, ...]
    submaps: tuple[Submap, ...]
    due: tuple[int, ...]
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
        memory.unsettled += len(found)
        poses = None
        late = newest - memory.optimized_at > _AFTER_KEYFRAMES
        if memory.unsettled and (self.settle or (found and (memory.wrong_m > _WRONG_M or late))):
            poses = self._corrected(found)
            memory.optimized_at = newest
            memory.wrong_m = 0.0
            memory.unsettled = 0
            memory.last_loop_m = self.keyframes[newest].travelled_m
        return LoopOutcome(tuple(found), poses, newest)

    def _corrected(self, found: list[Edge]) -> Mapping[int, Pose2]:
        poses = self.optimize(graph_arrays(self.poses, [*self.edges, *found]))
        return {
            id: Pose2(float(x), float(y), float(theta)) for id, (x, y, theta) in zip(self.poses, poses, strict=True)
        }

    def _loops_of(self, id: int) -> list[Edge]:
        keyframe, X_MK = self.keyframes[id], self.poses[id]
        if len(keyframe.points) < _LEAST_POINTS:
            return []
        edges = []
        for submap, window_m in self._candidates(id):
            X_MS = self.poses[submap.keyframes[0]]
            guess = X_MS.inverse() @ X_MK
            grid, pyramid = self._grid(submap)
            window_rad = 0.25 if window_m < 2.0 else 0.45
            start = sought(pyramid, keyframe.points, guess, window_m, window_rad, self.settings.loop_score)
            if start is None:
                continue
            fit = fitted(grid, keyframe.points, start[0], start[0], (1.0, 1.0), iterations=20, near_m=0.1)
            if not self._convincing(fit, start[0]):
                continue
            sigma_m, sigma_rad = _LOOP_SIGMAS
            share = fit.inliers
            information = (share / sigma_m**2, share / sigma_m**2, share / sigma_rad**2)
            edges.append(Edge(submap.keyframes[0], id, fit.X_SB, information, loop=True))
            self.memory.closed_at[submap.id] = id
            off = guess.inverse() @ fit.X_SB
            wrong = math.hypot(off.x, off.y) + _WRONG_PER_RAD * abs(off.theta)
            self.memory.wrong_m = max(self.memory.wrong_m, wrong)
        return edges

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
        near: list[tuple[float, Submap, float]] = []
        travelled = self.keyframes[id].travelled_m
        for submap in self.submaps:
            last = submap.keyframes[-1]
            if last > id - 2 * settings.submap_keyframes or id - memory.closed_at.get(submap.id, -99) < _REST_KEYFRAMES:
                continue
            seen_m = self.keyframes[last].travelled_m
            window = settings.loop_window_m
            if memory.last_loop_m < seen_m:
                window += settings.loop_window_m_per_m * (travelled - seen_m)
            window = min(window, settings.loop_window_max_m)
            away = min(math.hypot(self.poses[k].x - X_MK.x, self.poses[k].y - X_MK.y) for k in submap.keyframes[::3])
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


def pose_array(poses: Mapping[int, Pose2]) -> NDArray[np.float64]:
    """(N, 3) x, y, theta."""
    return np.array([(p.x, p.y, p.theta) for p in poses.values()], dtype=np.float64).reshape(-1, 3)
