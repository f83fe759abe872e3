"""Local costmap: a rolling grid in ``odom`` from laser and depth camera (thesis 4.2.2).

Laser and camera have layers of their own: a laser ray, which passes over a box, cannot clear it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, wrap_angle
from app.messages import Image, LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.costmap.footprint import Footprint

_NEVER = -(2**30)
#: Travel (m) before the grid rolls, and margin (m) around the footprint for returns from the robot itself.
_ROLL_M = 0.25
_ITSELF_M = 0.02
#: Times are int32 ms above ``_NEVER``, with a new epoch after this long (s).
_COUNTED_S = 1e6


@dataclass(frozen=True, slots=True)
class CostmapSettings:
    """Parameters of the local costmap.

    ``size_m``: side of the published window. ``memory_m``: side of the square within which obstacles are kept, so that
    an obstacle seen from afar is still there when the camera looks over it. ``clear_s``: time after the last hit from
    which a ray that passes clears a cell. Unseen cells are dropped after ``forget_s``, or after ``keep_s`` if they were
    hit for ``steady_s`` at least. Depth counts between ``floor_m`` + ``floor_slope`` * distance above the floor and the
    body's height, up to ``depth_m`` away, on every ``depth_step``-th pixel. ``drop_m``: a drop of the floor by more
    than this counts as an obstacle at its edge.
    """

    size_m: float = 4.0
    memory_m: float = 8.0
    resolution_m: float = 0.025
    clear_s: float = 0.25
    forget_s: float = 3.0
    steady_s: float = 1.0
    keep_s: float = 20.0
    floor_m: float = 0.05
    floor_slope: float = 0.015
    depth_m: float = 4.5
    depth_step: int = 4
    drop_m: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CostmapWindow:
    """The costmap around the robot at ``stamp``, in ``odom``.

    ``cells`` (N, N) int8: -1 never seen, 0 free, 100 occupied. ``distance`` (N, N) float32: m from each cell's middle
    to that of the nearest occupied cell (0 in one), including those around the window; ``memory_m`` at most.
    ``origin``: x, y (m) of the lower left corner of cell [0, 0]. ``obstacles`` (M, 2) float64: the middles of all
    occupied cells, also around the window, within the square from ``known_from`` of the side ``known_m``.
    """

    stamp: float
    origin: tuple[float, float]
    resolution_m: float
    cells: NDArray[np.int8]
    distance: NDArray[np.float32]
    obstacles: NDArray[np.float64]
    known_from: tuple[float, float]
    known_m: float

    def to_message(self, version: int) -> OccupancyGrid:
        return OccupancyGrid(
            self.stamp, "odom", cells=self.cells, resolution_m=self.resolution_m, origin=self.origin, version=version
        )


class LocalCostmap:
    """Keeps obstacles around the robot. Used by one thread at a time; every method computes for a few ms at most.

    Messages of one sensor come in the order of their stamps.
    """

    def __init__(self, footprint: Footprint, height_m: float, settings: CostmapSettings | None = None) -> None:
        self.settings = settings or CostmapSettings()
        self._height_m = height_m
        memory_m = max(self.settings.memory_m, self.settings.size_m + 2.0 * _ROLL_M + 0.1)
        self._side = math.ceil(memory_m / self.settings.resolution_m)
        self._edges = footprint.edges()
        self._itself = footprint.edges(_ITSELF_M)
        self._epoch: float | None = None
        self._corner: tuple[int, int] | None = None
        self.clear()

    def clear(self) -> None:
        """Drop all obstacles, as a recovery action."""
        shape = (self._side, self._side)
        self._laser_first, self._laser_last, self._seen, self._depth_first, self._depth_last = (
            np.full(shape, _NEVER, dtype=np.int32) for _ in range(5)
        )
        self._bands = np.zeros(shape, dtype=np.uint16)

    def add_scan(self, scan: LaserScan, X_OB: Pose2, X_OB_end: Pose2 | None = None) -> None:
        """Mark and clear by a scan. ``X_OB``: the robot at its stamp; ``X_OB_end``: at its last ray (default: the
        same); the rays between are interpolated."""
        from app.modules.behaviors.navigation.costmap.raytrace_kernels import free_body, sweep

        end = X_OB_end or X_OB
        self._roll(end)
        R, t = scan.X_BL.rotation, scan.X_BL.translation
        X_BL = Pose2(float(t[0]), float(t[1]), math.atan2(R[1, 0], R[0, 0]))
        # A laser mounted upside down sweeps the other way.
        way = 1.0 if R[2, 2] >= 0.0 else -1.0
        turn = wrap_angle(end.theta - X_OB.theta)
        begin_L, end_L = X_OB @ X_BL, end @ X_BL
        poses = np.array(
            [
                [begin_L.x, begin_L.y, begin_L.theta, X_OB.x, X_OB.y],
                [end_L.x, end_L.y, begin_L.theta + turn, end.x, end.y],
            ]
        )
        body = np.concatenate(([[X_OB.theta, X_OB.theta + turn, 0.0]], self._itself))
        sweep(
            np.array(scan.ranges, dtype=np.float32),
            way * scan.angle_min,
            way * scan.angle_increment,
            scan.range_min,
            scan.range_max,
            poses,
            body,
            self._frame(),
            self._ms(scan.stamp),
            _ms(self.settings.clear_s),
            self._laser_first,
            self._laser_last,
            self._seen,
        )
        free_body(_row(end), self._edges, self._frame(), self._laser_last, self._depth_last)

    def add_depth(self, image: Image, X_OB: Pose2) -> None:
        """Mark and clear by a depth image; ``X_OB``: the robot at its stamp.

        Raises ValueError for an image without depth or from a camera that is not a pinhole.
        """
        from app.modules.behaviors.navigation.costmap.depth_kernels import clear, mark

        camera, s = image.camera, self.settings
        if image.depth is None or not isinstance(camera, CameraModel):
            raise ValueError(f"obstacles are seen in a pinhole camera's depth: {image.frame} gives none")
        self._roll(X_OB)
        depth = np.array(image.depth)
        lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        X_BC = np.column_stack((image.X_BC.rotation, image.X_BC.translation))
        drop = math.inf if s.drop_m is None else s.drop_m
        limits = np.array([s.floor_m, s.floor_slope, self._height_m, s.depth_m, drop])
        frame, now = self._frame(), self._ms(image.stamp)
        seen, first, last, bands = (depth, lens, X_BC, _row(X_OB)), self._depth_first, self._depth_last, self._bands
        mark(*seen, self._itself, frame, limits, s.depth_step, now, first, last, bands)
        clear(*seen, frame, self._height_m, now, _ms(s.clear_s), last, bands)

    def around(self, X_OB: Pose2, stamp: float, known: NDArray[np.float64] | None = None) -> CostmapWindow:
        """The window at ``stamp``, not before the newest message; its middle is within a cell of ``X_OB``. ``known``
        (N, 2), m in ``odom``: further obstacles, except under the body itself: an obstacle under the body would be the
        nearest everywhere and hide all others."""
        from app.modules.behaviors.navigation.costmap.raytrace_kernels import standing

        self._roll(X_OB)
        s, now = self.settings, self._ms(stamp)
        free = np.ones((self._side, self._side), dtype=np.uint8)
        times = (_ms(s.forget_s), _ms(s.steady_s), _ms(s.keep_s))
        standing(self._laser_first, self._laser_last, now, *times, free)
        standing(self._depth_first, self._depth_last, now, *times, free)
        frame = self._frame()
        if known is not None and len(known):
            at = np.floor((known - frame[:2]) / s.resolution_m).astype(np.int64)
            at = at[((at >= 0) & (at < self._side)).all(axis=1)]
            at = at[~self._in_body((at + 0.5) * s.resolution_m + frame[:2], X_OB)]
            free[at[:, 1], at[:, 0]] = 0
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        resolution, size = s.resolution_m, round(s.size_m / s.resolution_m)
        row, column = (
            math.floor((p - q) / resolution) - size // 2 for p, q in ((X_OB.y, frame[1]), (X_OB.x, frame[0]))
        )
        window = (slice(row, row + size), slice(column, column + size))
        cells = np.where(
            free[window] == 0, np.int8(100), np.where(self._seen[window] == _NEVER, np.int8(-1), np.int8(0))
        )
        rows, columns = np.nonzero(free == 0)
        return CostmapWindow(
            stamp,
            (float(frame[0]) + column * resolution, float(frame[1]) + row * resolution),
            resolution_m=resolution,
            cells=cells,
            distance=np.minimum(distance[window] * np.float32(resolution), np.float32(self._side * resolution)),
            obstacles=np.stack((columns, rows), axis=-1) * resolution + (frame[:2] + 0.5 * resolution),
            known_from=(float(frame[0]), float(frame[1])),
            known_m=self._side * resolution,
        )

    def _in_body(self, points: NDArray[np.float64], X_OB: Pose2) -> NDArray[np.bool_]:
        """Which of ``points`` (N, 2), m in ``odom``, are within the body at ``X_OB``, or too near for its clearance."""
        beside = points - np.array([X_OB.x, X_OB.y])
        c, s = math.cos(X_OB.theta), math.sin(X_OB.theta)
        reach = (beside @ np.array([[c, -s], [s, c]])) @ self._edges[:, :2].T
        return np.asarray((reach <= self._edges[:, 2] + self.settings.resolution_m).all(axis=1))

    def _roll(self, X_OB: Pose2) -> None:
        """Keep the robot near the grid's middle."""
        resolution, half = self.settings.resolution_m, self._side // 2
        corner = (math.floor(X_OB.y / resolution) - half, math.floor(X_OB.x / resolution) - half)
        if self._corner is None:
            self._corner = corner
        down, right = corner[0] - self._corner[0], corner[1] - self._corner[1]
        if max(abs(down), abs(right)) * resolution <= _ROLL_M:
            return
        self._corner = corner
        for grid in (self._laser_first, self._laser_last, self._seen, self._depth_first, self._depth_last, self._bands):
            _shift(grid, down, right)

    def _frame(self) -> NDArray[np.float64]:
        row, column = self._corner or (0, 0)
        resolution = self.settings.resolution_m
        return np.array([column * resolution, row * resolution, resolution])

    def _ms(self, stamp: float) -> int:
        """Milliseconds since the epoch of the grid."""
        if self._epoch is None:
            self._epoch = stamp
        if stamp - self._epoch > _COUNTED_S:
            passed = round(1000.0 * (stamp - self._epoch))
            self._epoch = stamp
            for grid in (self._laser_first, self._laser_last, self._seen, self._depth_first, self._depth_last):
                known = grid != _NEVER
                grid[known] = np.maximum(grid[known] - np.int64(passed), _NEVER + 1)
        return round(1000.0 * (stamp - self._epoch))


def _shift(grid: NDArray[np.generic], down: int, right: int) -> None:
    """Move the contents of ``grid`` towards its beginning; new cells are empty."""
    side = len(grid)
    before = grid.copy()
    grid.fill(0 if grid.dtype == np.uint16 else _NEVER)
    if max(abs(down), abs(right)) < side:
        to_rows, from_rows = _overlap(down, side)
        to_columns, from_columns = _overlap(right, side)
        grid[to_rows, to_columns] = before[from_rows, from_columns]


def _overlap(by: int, side: int) -> tuple[slice, slice]:
    return slice(max(-by, 0), side - max(by, 0)), slice(max(by, 0), side - max(-by, 0))


def _row(pose: Pose2) -> NDArray[np.float64]:
    return np.array([pose.x, pose.y, pose.theta])


def _ms(seconds: float) -> int:
    return round(1000.0 * seconds)
