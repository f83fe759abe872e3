"""Reference path of the controllers: evenly spaced points from beside the body on, with the allowed speed at each."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.controller import LocalPath

#: Spacing of the points, m.
SPACING_M = 0.05

#: Speeds (N,) m/s allowed at points (N, 2) of the map.
SpeedAt = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class ReferencePath:
    """One planned path on the map, and the body's progress along it.

    ``path`` (N, 2 or 3) float64: x, y (m) of its corners. ``speed_mps``: greatest speed; ``speed_at``: a lower one by
    place (zones). Toward the end the speed falls so that ``braking_mps2`` stops the body there.
    """

    def __init__(
        self, path: NDArray[np.float64], *, speed_mps: float, braking_mps2: float, speed_at: SpeedAt | None = None
    ) -> None:
        self.points = resampled(np.asarray(path, dtype=np.float64)[:, :2], SPACING_M)
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        self.lengths = np.concatenate(([0.0], np.cumsum(steps)))
        self.headings = _headings(self.points)
        self._braking_mps2 = braking_mps2
        caps = np.full(len(self.points), speed_mps)
        if speed_at is not None:
            caps = np.minimum(caps, speed_at(self.points))
        self._caps = _braked(caps, steps, braking_mps2)
        self._at = 0

    @property
    def length_m(self) -> float:
        """Length of the whole path (m)."""
        return float(self.lengths[-1])

    @property
    def end(self) -> Pose2:
        return Pose2(float(self.points[-1, 0]), float(self.points[-1, 1]), float(self.headings[-1]))

    def come_to(self, X_MB: Pose2) -> tuple[float, float]:
        """Take the body's pose; returns the remaining length from the nearest point and the distance from the path (m).

        The nearest point is searched around the last one: a path that passes the same place twice is followed in order.
        """
        low, high = max(0, self._at - 20), min(len(self.points), self._at + 60)
        off = np.hypot(self.points[low:high, 0] - X_MB.x, self.points[low:high, 1] - X_MB.y)
        self._at = low + int(off.argmin())
        return self.length_m - float(self.lengths[self._at]), float(off.min())

    def ahead(self, X_FM: Pose2, length_m: float, *, stop: bool = True) -> LocalPath:
        """The next ``length_m`` of the path from the body on, in frame F; slower toward the path's end, if it is to
        ``stop``."""
        count = max(2, int(length_m / SPACING_M) + 1)
        low = min(self._at, len(self.points) - 2)
        points = self.points[low : low + count]
        c, s = math.cos(X_FM.theta), math.sin(X_FM.theta)
        way = np.empty((len(points), 5))
        way[:, 0] = X_FM.x + c * points[:, 0] - s * points[:, 1]
        way[:, 1] = X_FM.y + s * points[:, 0] + c * points[:, 1]
        way[:, 2] = self.headings[low : low + count] + X_FM.theta
        way[:, 3] = self.lengths[low : low + count] - self.lengths[low]
        way[:, 4] = self._caps[low : low + count]
        if stop:
            remaining = np.maximum(self.length_m - self.lengths[low : low + count], 0.0)
            way[:, 4] = np.minimum(way[:, 4], np.sqrt(2.0 * 0.6 * self._braking_mps2 * remaining) + 0.02)
        return LocalPath(way, SPACING_M)

    def rest(self) -> NDArray[np.float64]:
        """The remaining path (N, 2), on the map."""
        return self.points[min(self._at, len(self.points) - 2) :]


def resampled(points: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """The polyline ``points`` (N, 2) at every ``spacing_m`` of its length; two points at least, both ends included."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    lengths = np.concatenate(([0.0], np.cumsum(steps)))
    keep = np.concatenate(([True], steps > 1e-9))
    lengths, points = lengths[keep], points[keep]
    if len(points) < 2:
        return np.ascontiguousarray(np.repeat(points[:1], 2, axis=0))
    count = max(2, round(float(lengths[-1]) / spacing_m) + 1)
    at = np.linspace(0.0, float(lengths[-1]), count)
    return np.stack((np.interp(at, lengths, points[:, 0]), np.interp(at, lengths, points[:, 1])), axis=1)


def _headings(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heading of the path over 0.1 m around each point; 0 for a path without length."""
    before = points[np.maximum(np.arange(len(points)) - 1, 0)]
    after = points[np.minimum(np.arange(len(points)) + 1, len(points) - 1)]
    return np.arctan2(after[:, 1] - before[:, 1], after[:, 0] - before[:, 0])


def _braked(caps: NDArray[np.float64], steps: NDArray[np.float64], braking_mps2: float) -> NDArray[np.float64]:
    """``caps`` (N,) lowered so that the caps of later points can be reached by braking."""
    squares = caps**2
    for k in range(len(steps) - 1, -1, -1):
        squares[k] = min(squares[k], squares[k + 1] + 2.0 * braking_mps2 * steps[k])
    return np.asarray(np.sqrt(squares))
