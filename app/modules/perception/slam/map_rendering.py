"""Rendering of the occupancy grid from keyframes, incrementally: only new, removed and moved keyframes are drawn."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.base.geometry import Pose2
from app.modules.perception.slam.occupancy import OccupancyCounts, ScanView
from app.modules.perception.slam.types import Keyframe

#: Greatest number of extra views per keyframe: later views clear people who stood there.
GLANCES = 8


@dataclass(frozen=True, slots=True, eq=False)
class ExtraView:
    """A further view from near a keyframe; ``X_KV``: pose of the body in the keyframe's frame."""

    keyframe: int
    X_KV: Pose2
    view: ScanView


@dataclass(slots=True, eq=False)
class _Drawn:
    """A keyframe as drawn in the grid."""

    view: ScanView
    pose: Pose2
    #: Distance (m) within which most of its readings are: the lever arm of a rotation.
    size: float
    glances: deque[ExtraView] = field(default_factory=deque)


class MapRenderer:
    """Draws keyframes and extra views into ``counts``. Used by one thread at a time."""

    def __init__(self, counts: OccupancyCounts | None = None) -> None:
        self.counts = counts or OccupancyCounts()
        self._drawn: dict[int, _Drawn] = {}

    def extra_view(self, extra_view: ExtraView) -> None:
        """Add one view and drop the oldest of its keyframe; no effect where the keyframe is not drawn."""
        drawn = self._drawn.get(extra_view.keyframe)
        if drawn is None:
            return
        if len(drawn.glances) == GLANCES:
            oldest = drawn.glances.popleft()
            self.counts.remove(oldest.view, drawn.pose @ oldest.X_KV)
        drawn.glances.append(extra_view)
        self.counts.add(extra_view.view, drawn.pose @ extra_view.X_KV)

    def update(self, keyframes: Mapping[int, Keyframe], poses: Mapping[int, Pose2], most: int = 50) -> bool:
        """Draw up to ``most`` keyframes that are new, removed or more than half a cell from their drawn place.

        Returns whether more are left.
        """
        left = most
        for id in [id for id in self._drawn if id not in poses]:
            if not left:
                return True
            self._erase(self._drawn.pop(id))
            left -= 1
        tolerance = self.counts.resolution_m / 2
        for id, pose in poses.items():
            drawn = self._drawn.get(id)
            if drawn is not None and _moved(drawn.pose, pose, drawn.size) <= tolerance:
                continue
            if not left:
                return True
            left -= 1
            if drawn is None:
                view = ScanView.of(keyframes[id])
                drawn = self._drawn[id] = _Drawn(view, pose, _size(view))
            else:
                self._erase(drawn)
                drawn.pose = pose
            self.counts.add(drawn.view, pose)
            for extra_view in drawn.glances:
                self.counts.add(extra_view.view, pose @ extra_view.X_KV)
        return False

    def _erase(self, drawn: _Drawn) -> None:
        self.counts.remove(drawn.view, drawn.pose)
        for extra_view in drawn.glances:
            self.counts.remove(extra_view.view, drawn.pose @ extra_view.X_KV)


def _moved(before: Pose2, now: Pose2, size_m: float) -> float:
    """Displacement (m) of most of the readings."""
    turn = math.remainder(now.theta - before.theta, math.tau)
    return math.hypot(now.x - before.x, now.y - before.y) + abs(turn) * size_m


def _size(view: ScanView) -> float:
    far = np.hypot(*view.ends[view.met].T) if view.met.any() else np.zeros(1)
    return float(np.percentile(far, 70))
