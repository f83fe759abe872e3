"""Stall detection: the base is commanded forward and does not move, so it touches an obstacle that no sensor sees.

No sensor covers obstacles lower than the laser and nearer than the camera's field of view. The area before the body is
marked occupied for a limited time, for the controller and the planner, so that the path leads around it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.controller import BodyModel, MotionState
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow


@dataclass(frozen=True, slots=True)
class StallSettings:
    """A stall: speed at most ``standing_mps`` for ``stalled_s``, with a lag of ``behind_m`` behind the commanded
    forward motion. The obstacle is placed ``ahead_m`` before the body's edge and kept for ``keep_s``."""

    behind_m: float = 0.04
    standing_mps: float = 0.02
    stalled_s: float = 0.6
    ahead_m: float = 0.06
    keep_s: float = 40.0


class StallDetector:
    """Detects stalls and keeps their places, in ``odom``."""

    def __init__(self, body: BodyModel, settings: StallSettings | None = None) -> None:
        self._settings = settings or StallSettings()
        edge = body.outline[: len(body.outline) // 2]
        front = edge[edge[:, 0] > 0.5 * body.front_m]
        lengths = np.linalg.norm(front, axis=1, keepdims=True)
        self._front = front * (1.0 + self._settings.ahead_m / lengths)
        self._contacts: list[tuple[float, NDArray[np.float64]]] = []
        self._since: float | None = None
        self._before = 0.0
        self._behind_m = 0.0

    def update(self, now: float, commanded_mps: float, motion: MotionState) -> bool:
        """Take the last forward command of the base and the body's motion; returns whether a stall was detected now."""
        s = self._settings
        if commanded_mps <= 0.0 or motion.speed_mps > s.standing_mps:
            self._since = None
            return False
        if self._since is None:
            self._since, self._before, self._behind_m = now, now, 0.0
        # The sum counts, not a single difference: against an obstacle, commands restart from zero again and again.
        self._behind_m += (commanded_mps - abs(motion.linear_mps)) * (now - self._before)
        self._before = now
        if now - self._since < s.stalled_s or self._behind_m < s.behind_m:
            return False
        self._since = None
        c, d = np.cos(motion.pose.theta), np.sin(motion.pose.theta)
        x, y = self._front[:, 0], self._front[:, 1]
        points = np.stack((motion.pose.x + c * x - d * y, motion.pose.y + d * x + c * y), axis=1)
        self._contacts.append((now, points))
        return True

    @property
    def newest(self) -> NDArray[np.float64]:
        """Place of the last stall: points (N, 2) m in ``odom``."""
        return self._contacts[-1][1] if self._contacts else np.empty((0, 2))

    def clear(self) -> None:
        """Drop all places."""
        self._contacts.clear()

    def laid_over(self, around: CostmapWindow, now: float) -> CostmapWindow:
        """``around`` with the places of stalls marked occupied."""
        self._contacts = [(stamp, points) for stamp, points in self._contacts if now - stamp < self._settings.keep_s]
        if not self._contacts:
            return around
        points = np.concatenate([points for _, points in self._contacts])
        rows, columns = around.distance.shape
        distance = around.distance.copy()
        x = around.origin[0] + (np.arange(columns) + 0.5) * around.resolution_m
        y = around.origin[1] + (np.arange(rows) + 0.5) * around.resolution_m
        # Every third point: their spacing is below a cell.
        for px, py in points[::3]:
            np.minimum(distance, np.hypot(x[None, :] - px, y[:, None] - py), out=distance, casting="same_kind")
        low = np.array(around.known_from)
        known = ((points >= low) & (points < low + around.known_m)).all(axis=1)
        return replace(around, distance=distance, obstacles=np.concatenate((around.obstacles, points[known])))
