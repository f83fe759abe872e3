"""What the body ran into without having seen it: it is commanded forward and does not move.

Nothing else tells of what is lower than the laser and nearer than the camera sees. The place before the body is taken
for occupied for a while, by the controller and by whoever plans, so that the way leads around it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.controller import BodyModel, MotionState
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow


@dataclass(frozen=True, slots=True)
class StallSettings:
    """Going at most ``standing_mps`` for ``stalled_s`` and falling behind by ``behind_m`` what is commanded forward is
    running into something ``ahead_m`` before the body's edge; it is believed for ``keep_s``."""

    behind_m: float = 0.04
    standing_mps: float = 0.02
    stalled_s: float = 0.6
    ahead_m: float = 0.06
    keep_s: float = 40.0


class StallDetector:
    """Remembers, in ``odom``, where the body ran into something."""

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
        """Take what the base was given last and how the body moves; whether it just ran into something."""
        s = self._settings
        if commanded_mps <= 0.0 or abs(motion.linear_mps) > s.standing_mps:
            self._since = None
            return False
        if self._since is None:
            self._since, self._before, self._behind_m = now, now, 0.0
        # Not how much at once: against something, commands begin anew from standing again and again.
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
        """Where it ran into something last: points (N, 2) m in ``odom``."""
        return self._contacts[-1][1] if self._contacts else np.empty((0, 2))

    def clear(self) -> None:
        """Nothing was there."""
        self._contacts.clear()

    def laid_over(self, around: CostmapWindow, now: float) -> CostmapWindow:
        """``around`` with what was run into."""
        self._contacts = [(stamp, points) for stamp, points in self._contacts if now - stamp < self._settings.keep_s]
        if not self._contacts:
            return around
        points = np.concatenate([points for _, points in self._contacts])
        rows, columns = around.distance.shape
        distance = around.distance.copy()
        x = around.origin[0] + (np.arange(columns) + 0.5) * around.resolution_m
        y = around.origin[1] + (np.arange(rows) + 0.5) * around.resolution_m
        # Every third: they stand closer than cells.
        for px, py in points[::3]:
            np.minimum(distance, np.hypot(x[None, :] - px, y[:, None] - py), out=distance, casting="same_kind")
        low = np.array(around.known_from)
        known = ((points >= low) & (points < low + around.known_m)).all(axis=1)
        return replace(around, distance=distance, obstacles=np.concatenate((around.obstacles, points[known])))
