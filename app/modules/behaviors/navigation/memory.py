"""What the camera saw and the laser never will: low and overhanging things, kept on the map until seen to be gone.

A camera at head height that looks straight ahead sees a low box from 3 m on and looks over it from there: whoever turns
beside one, or comes back to it from elsewhere, must have kept it. The costmap, which rolls along in ``odom``, forgets
what it leaves behind; this lies in ``map``, for the whole of it, and is kept with the map.

What stands where the laser sees something needs no memory: walls and furniture the map has, and people go away. So
nothing is taken within ``laser_m`` of what the laser sees just then, nor what was not seen to stand for ``steady_s``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import cv2
import numpy as np
from numpy.typing import NDArray

from app.geometry import CameraModel, Pose2
from app.messages import Image
from app.modules.behaviors.navigation.footprint import Footprint

_NEVER = -(2**30)
#: Times are kept in ms of 32 bits, counted anew after this long (s).
_COUNTED_S = 1e6
#: The grid grows by tiles of so many cells.
_TILE = 64
#: Where the body has been, nothing stands; so much (m) of its edge is left to what its place on the map is unsure by.
_UNSURE_M = 0.04
#: The bands of height (of 16) that something felt by the base is taken to stand at.
_FELT_BANDS = 0b111
_VERSION = 1


class UnreadableMemory(ValueError):
    """What was kept with the map is damaged, or of another version."""


@dataclass(frozen=True, slots=True)
class MemorySettings:
    """Depth counts as in ``CostmapSettings``, within ``reach_m`` of the camera; each cell of ``resolution_m`` is kept
    once it was hit for ``steady_s`` with no gap of ``again_s``. Pictures closer together than ``every_s`` are passed
    over."""

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


class ThingsMemory:
    """Keeps things on the map. Not for two threads at once; every method computes for a few ms at most."""

    def __init__(self, footprint: Footprint, height_m: float, settings: MemorySettings | None = None) -> None:
        self.settings = settings or MemorySettings()
        self._height_m = height_m
        sides = np.roll(footprint.corners, -1, axis=0) - footprint.corners
        normals = np.stack((sides[:, 1], -sides[:, 0]), axis=-1) / np.linalg.norm(sides, axis=1, keepdims=True)
        reach = (normals * footprint.corners).sum(axis=1)
        self._itself = np.column_stack((normals, reach))
        self._inside = np.column_stack((normals, reach - _UNSURE_M))
        #: Grows with every change of what is kept, also to another map's.
        self.version = 0
        self.forget()

    def forget(self) -> None:
        """Another map."""
        self._row, self._column = 0, 0
        self._first, self._last = (np.full((_TILE, _TILE), _NEVER, dtype=np.int32) for _ in range(2))
        self._bands = np.zeros((_TILE, _TILE), dtype=np.uint16)
        self._kept = np.zeros((_TILE, _TILE), dtype=np.bool_)
        self._epoch: float | None = None
        self._looked_at = -math.inf
        self.version += 1

    @property
    def points(self) -> NDArray[np.float64]:
        """The middles (N, 2) of the cells that are kept, m on the map."""
        return self._middles(self._kept, self._row, self._column)

    def near(self, X_MO: Pose2, X_OB: Pose2, within_m: float) -> NDArray[np.float64]:
        """What is kept within a square around the robot: points (N, 2) m in ``odom``, two by two in each cell."""
        place = X_MO @ X_OB
        r0, r1, c0, c1 = self._box(place, within_m)
        rows, columns = self._kept.shape
        r0, r1 = max(r0 - self._row, 0), min(r1 - self._row, rows)
        c0, c1 = max(c0 - self._column, 0), min(c1 - self._column, columns)
        if r0 >= r1 or c0 >= c1:
            return np.empty((0, 2))
        middles = self._middles(self._kept[r0:r1, c0:c1], self._row + r0, self._column + c0)
        if not len(middles):
            return middles
        quarter = 0.25 * self.settings.resolution_m
        corners = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]) * quarter
        return _moved((middles[:, None, :] + corners).reshape(-1, 2), X_MO.inverse())

    def look(self, image: Image, X_MB: Pose2, laser: NDArray[np.float64]) -> None:
        """Take a depth picture, the robot being at ``X_MB`` at its stamp; ``laser`` (N, 2): what the laser sees about
        then, m on the map. Raises ValueError for a picture without depth or from a camera that is not a pinhole."""
        from app.modules.behaviors.navigation.depth import clear, mark
        from app.modules.behaviors.navigation.rays import free_body

        s, camera = self.settings, image.camera
        if image.depth is None or not isinstance(camera, CameraModel):
            raise ValueError(f"things are seen in a pinhole camera's depth: {image.frame} gives none")
        if 0.0 <= image.stamp - self._looked_at < s.every_s:
            return
        self._looked_at = image.stamp
        now = self._ms(image.stamp)
        window, frame = self._window(X_MB, s.reach_m + 0.5)
        first, last, bands = self._first[window].copy(), self._last[window].copy(), self._bands[window].copy()
        kept, before = self._kept[window], self._last[window]
        lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        X_BC = np.column_stack((image.X_BC.rotation, image.X_BC.translation))
        pose = np.array([X_MB.x, X_MB.y, X_MB.theta])
        depth = np.array(image.depth)
        limits = np.array([s.floor_m, s.floor_slope, self._height_m, s.reach_m, math.inf])
        mark(depth, lens, X_BC, pose, self._itself, frame, limits, s.depth_step, now, first, last, bands)
        hit = last == now
        seen_by_laser = hit & ~kept & self._beside(laser, frame, hit.shape)
        first[seen_by_laser] = self._first[window][seen_by_laser]
        last[seen_by_laser] = before[seen_by_laser]
        bands[seen_by_laser] = self._bands[window][seen_by_laser]
        hit &= ~seen_by_laser
        first[hit & ~kept & (now - before.astype(np.int64) > _ms(s.again_s))] = now
        stands = kept | (hit & (now - first >= _ms(s.steady_s)))
        clear(depth, lens, X_BC, pose, frame, self._height_m, now, _ms(s.clear_s), last, bands)
        free_body(pose, self._inside, frame, last, last)
        stands &= last != _NEVER
        if (stands != kept).any():
            self.version += 1
        self._first[window], self._last[window], self._bands[window], self._kept[window] = first, last, bands, stands

    def felt(self, points: NDArray[np.float64], stamp: float) -> None:
        """The base ran into something at ``points`` (N, 2) m on the map."""
        if not len(points):
            return
        now, resolution = self._ms(stamp), self.settings.resolution_m
        cells = np.floor(points / resolution).astype(np.int64)
        self._cover(*(int(v) for v in (*cells.min(axis=0)[::-1], *(cells.max(axis=0) + 1)[::-1])))
        rows, columns = cells[:, 1] - self._row, cells[:, 0] - self._column
        self._first[rows, columns] = self._last[rows, columns] = now
        self._bands[rows, columns] |= _FELT_BANDS
        self._kept[rows, columns] = True
        self.version += 1

    def save(self, file: Path) -> None:
        """Write what is kept (NumPy's npz). Raises OSError."""
        rows, columns = np.nonzero(self._kept)
        cells = np.stack((rows + self._row, columns + self._column), axis=-1).astype(np.int32)
        with file.open("wb") as out:
            np.savez_compressed(
                out, version=_VERSION, resolution_m=self.settings.resolution_m, cells=cells,
                bands=self._bands[rows, columns],
            )  # fmt: skip

    def load(self, file: Path) -> None:
        """Take what was kept with a map in place of what is known; nothing where there is no file.

        Raises UnreadableMemory, and OSError; then nothing has changed.
        """
        cells, bands = np.empty((0, 2), dtype=np.int32), np.empty(0, dtype=np.uint16)
        if file.exists():
            try:
                with file.open("rb") as data, np.load(data, allow_pickle=False) as kept:
                    version, resolution = int(kept["version"]), float(kept["resolution_m"])
                    cells, bands = kept["cells"].astype(np.int64).reshape(-1, 2), kept["bands"].astype(np.uint16)
            except (ValueError, KeyError, EOFError, TypeError, BadZipFile) as damage:
                raise UnreadableMemory(f"{file} is damaged: {damage}") from None
            if version != _VERSION or resolution != self.settings.resolution_m or len(cells) != len(bands):
                raise UnreadableMemory(f"{file} is of another version")
        self.forget()
        if len(cells):
            self._cover(*(int(v) for v in (*cells.min(axis=0), *(cells.max(axis=0) + 1))))
            rows, columns = cells[:, 0] - self._row, cells[:, 1] - self._column
            self._first[rows, columns] = self._last[rows, columns] = 0
            self._bands[rows, columns] = bands
            self._kept[rows, columns] = True

    def _middles(self, which: NDArray[np.bool_], row: int, column: int) -> NDArray[np.float64]:
        rows, columns = np.nonzero(which)
        return np.asarray((np.stack((columns + column, rows + row), axis=-1) + 0.5) * self.settings.resolution_m)

    def _beside(
        self, points: NDArray[np.float64], frame: NDArray[np.float64], shape: tuple[int, ...]
    ) -> NDArray[np.bool_]:
        """Which cells of a window lie within ``laser_m`` of ``points``."""
        there = np.zeros(shape, dtype=np.uint8)
        cells = np.floor((points - frame[:2]) / frame[2]).astype(np.int64)
        cells = cells[((cells >= 0) & (cells < np.array(shape)[::-1])).all(axis=1)]
        there[cells[:, 1], cells[:, 0]] = 1
        radius = math.ceil(self.settings.laser_m / frame[2])
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        return np.asarray(cv2.dilate(there, disc).view(np.bool_))

    def _box(self, place: Pose2, within_m: float) -> tuple[int, int, int, int]:
        r = self.settings.resolution_m
        return (
            math.floor((place.y - within_m) / r), math.ceil((place.y + within_m) / r),
            math.floor((place.x - within_m) / r), math.ceil((place.x + within_m) / r),
        )  # fmt: skip

    def _window(self, place: Pose2, within_m: float) -> tuple[tuple[slice, slice], NDArray[np.float64]]:
        """The cells around ``place``, and their frame: x, y (m) of the lower left corner, and the size of a cell."""
        r0, r1, c0, c1 = self._box(place, within_m)
        self._cover(r0, c0, r1, c1)
        window = (slice(r0 - self._row, r1 - self._row), slice(c0 - self._column, c1 - self._column))
        resolution = self.settings.resolution_m
        return window, np.array([c0 * resolution, r0 * resolution, resolution])

    def _cover(self, r0: int, c0: int, r1: int, c1: int) -> None:
        """Have the grid hold the cells of rows ``r0`` to ``r1`` and columns ``c0`` to ``c1``, both ends excluded."""
        rows, columns = self._kept.shape
        low = (min(r0 // _TILE * _TILE, self._row), min(c0 // _TILE * _TILE, self._column))
        high = (max(-(-r1 // _TILE) * _TILE, self._row + rows), max(-(-c1 // _TILE) * _TILE, self._column + columns))
        if low == (self._row, self._column) and high == (self._row + rows, self._column + columns):
            return
        margin = (
            (self._row - low[0], high[0] - self._row - rows), (self._column - low[1], high[1] - self._column - columns)
        )  # fmt: skip
        self._first, self._last = (np.pad(grid, margin, constant_values=_NEVER) for grid in (self._first, self._last))
        self._bands, self._kept = np.pad(self._bands, margin), np.pad(self._kept, margin)
        self._row, self._column = low

    def _ms(self, stamp: float) -> int:
        """Counted from a picture not too long ago; what was kept before the first one is as old as that."""
        if self._epoch is None:
            self._epoch = stamp - 1.0
        if stamp - self._epoch > _COUNTED_S:
            self._epoch = stamp - 1.0
            self._first[self._kept] = self._last[self._kept] = 0
            self._first[~self._kept] = self._last[~self._kept] = _NEVER
        return round(1000.0 * (stamp - self._epoch))


def _moved(points: NDArray[np.float64], pose: Pose2) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + np.array([pose.x, pose.y]))


def _ms(seconds: float) -> int:
    return round(1000.0 * seconds)
