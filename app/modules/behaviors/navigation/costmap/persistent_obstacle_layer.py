"""Persistent obstacles: low and overhanging objects that the camera sees and the laser does not, kept on the map.

A camera at head height that looks level sees a low box up to a distance of 3 m and looks over it from there on; one
that is turned aside does not see it at all. A robot that turns beside the box, or comes back to it, needs the earlier
observation. The local costmap rolls along in ``odom`` and drops cells behind it; this layer is in ``map``, covers all
of it, and is saved with the map.

Obstacles that the laser sees are not kept: walls and furniture are on the map, and people leave. A cell is not taken
within ``laser_m`` of the current scan's points, nor before it was hit for ``steady_s``. It is removed when the camera
looks through it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2
from app.messages import Image
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.persistent_obstacle_file import PersistentObstacles
from app.modules.behaviors.navigation.costmap.tiled_grid import NEVER, TILE, Box, CellBlock, TiledGrid

#: Times are int32 ms, with a new epoch after this long (s).
_COUNTED_S = 1e6
#: The robot's own path is free of obstacles; this much (m) of the footprint's edge is left out, for the error of its
#: pose.
_UNSURE_M = 0.04
#: Height bands (of 16) of an obstacle that the base touched.
_FELT_BANDS = 0b111


@dataclass(frozen=True, slots=True)
class PersistentObstacleSettings:
    """Depth counts as in ``CostmapSettings``, within ``reach_m`` of the camera. A cell of ``resolution_m`` is kept once
    it was hit for ``steady_s`` without a gap of ``again_s``. Images less than ``every_s`` apart are skipped."""

    resolution_m: float = 0.05
    every_s: float = 0.15
    steady_s: float = 0.4
    again_s: float = 1.0
    laser_m: float = 0.25
    clear_s: float = 0.25
    floor_m: float = 0.05
    floor_slope: float = 0.015
    reach_m: float = 4.5
    depth_step: int = 4


class PersistentObstacleLayer:
    """Persistent obstacles on the map. Used by one thread at a time; every method computes for a few ms at most."""

    def __init__(
        self, footprint: Footprint, height_m: float, settings: PersistentObstacleSettings | None = None
    ) -> None:
        self.settings = settings or PersistentObstacleSettings()
        self._height_m = height_m
        self._itself = footprint.edges()
        self._inside = footprint.edges(-_UNSURE_M)
        #: Incremented with every change of the kept cells, and with a change of the map.
        self.version = 0
        self.clear()

    def clear(self) -> None:
        """Drop all cells, for another map."""
        self._grid = TiledGrid()
        self._epoch: float | None = None
        self._looked_at = -math.inf
        self.version += 1

    @property
    def points(self) -> NDArray[np.float64]:
        """The middles (N, 2) of the kept cells, m on the map."""
        return self._middles(self._grid.kept())

    @property
    def cells_held(self) -> int:
        """For how many cells there is memory: what is kept, and around the robot. Tests hold its bound by it."""
        return len(self._grid) * TILE**2

    def near(self, X_MO: Pose2, X_OB: Pose2, within_m: float) -> NDArray[np.float64]:
        """Kept cells within a square around the robot: points (N, 2) m in ``odom``, four in each cell."""
        place = X_MO @ X_OB
        middles = self._middles(self._grid.kept(self._box(place, within_m)))
        if not len(middles):
            return middles
        quarter = 0.25 * self.settings.resolution_m
        corners = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]) * quarter
        return X_MO.inverse().transform((middles[:, None, :] + corners).reshape(-1, 2))

    def look(self, image: Image, X_MB: Pose2, laser: NDArray[np.float64]) -> None:
        """Take a depth image; ``X_MB``: the robot at its stamp; ``laser`` (N, 2): points of a scan of about that time,
        m on the map. Raises ValueError for an image without depth or from a camera that is not a pinhole."""
        from app.modules.behaviors.navigation.costmap.depth_kernels import clear, mark
        from app.modules.behaviors.navigation.costmap.raytrace_kernels import free_body

        s, camera = self.settings, image.camera
        if image.depth is None or not isinstance(camera, CameraModel):
            raise ValueError(f"things are seen in a pinhole camera's depth: {image.frame} gives none")
        if 0.0 <= image.stamp - self._looked_at < s.every_s:
            return
        self._looked_at = image.stamp
        now = self._ms(image.stamp)
        box = self._box(X_MB, s.reach_m + 0.5)
        frame = np.array([box[2] * s.resolution_m, box[0] * s.resolution_m, s.resolution_m])
        former = self._grid.read(box)
        first, last, bands, kept = former.first.copy(), former.last.copy(), former.bands.copy(), former.kept
        lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        X_BC = np.column_stack((image.X_BC.rotation, image.X_BC.translation))
        pose = np.array([X_MB.x, X_MB.y, X_MB.theta])
        depth = np.array(image.depth)
        limits = np.array([s.floor_m, s.floor_slope, self._height_m, s.reach_m, math.inf])
        mark(depth, lens, X_BC, pose, self._itself, frame, limits, s.depth_step, now, first, last, bands)
        hit = last == now
        seen_by_laser = hit & ~kept & self._beside(laser, frame, hit.shape)
        first[seen_by_laser] = former.first[seen_by_laser]
        last[seen_by_laser] = former.last[seen_by_laser]
        bands[seen_by_laser] = former.bands[seen_by_laser]
        hit &= ~seen_by_laser
        first[hit & ~kept & (now - former.last.astype(np.int64) > _ms(s.again_s))] = now
        stands = kept | (hit & (now - first >= _ms(s.steady_s)))
        clear(depth, lens, X_BC, pose, frame, self._height_m, now, _ms(s.clear_s), last, bands)
        free_body(pose, self._inside, frame, last, last)
        stands &= last != NEVER
        if (stands != kept).any():
            self.version += 1
        self._grid.write(box, CellBlock(first, last, bands, stands))

    def add_contacts(self, points: NDArray[np.float64], stamp: float) -> None:
        """Take places (N, 2), m on the map, where the base was stopped by an obstacle."""
        if not len(points):
            return
        now = self._ms(stamp)
        cells = np.floor(points[:, ::-1] / self.settings.resolution_m).astype(np.int64)
        self._grid.keep(cells, np.full(len(cells), _FELT_BANDS, dtype=np.uint16), now)
        self.version += 1

    def snapshot(self) -> PersistentObstacles:
        """The kept cells."""
        return PersistentObstacles(self._grid.kept(), self._grid.bands())

    def take(self, obstacles: PersistentObstacles) -> None:
        """Replace all cells by those saved with a map."""
        self.clear()
        if len(obstacles.cells):
            self._grid.keep(obstacles.cells, obstacles.bands, 0)

    def _middles(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        return np.asarray((cells[:, ::-1] + 0.5) * self.settings.resolution_m)

    def _beside(
        self, points: NDArray[np.float64], frame: NDArray[np.float64], shape: tuple[int, ...]
    ) -> NDArray[np.bool_]:
        """Which cells of a window are within ``laser_m`` of ``points``."""
        there = np.zeros(shape, dtype=np.uint8)
        cells = np.floor((points - frame[:2]) / frame[2]).astype(np.int64)
        cells = cells[((cells >= 0) & (cells < np.array(shape)[::-1])).all(axis=1)]
        there[cells[:, 1], cells[:, 0]] = 1
        radius = math.ceil(self.settings.laser_m / frame[2])
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        return np.asarray(cv2.dilate(there, disc).view(np.bool_))

    def _box(self, place: Pose2, within_m: float) -> Box:
        r = self.settings.resolution_m
        return (
            math.floor((place.y - within_m) / r), math.ceil((place.y + within_m) / r),
            math.floor((place.x - within_m) / r), math.ceil((place.x + within_m) / r),
        )  # fmt: skip

    def _ms(self, stamp: float) -> int:
        """Milliseconds since the epoch; cells kept before the first image are at the epoch."""
        if self._epoch is None:
            self._epoch = stamp - 1.0
        if stamp - self._epoch > _COUNTED_S:
            self._epoch = stamp - 1.0
            self._grid.recount()
        return round(1000.0 * (stamp - self._epoch))


def _ms(seconds: float) -> int:
    return round(1000.0 * seconds)
