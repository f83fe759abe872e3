"""What the depth camera saw lately, as voxels in odometry's frame: bounded, fading, cleared where seen through.

Pure: no clock of its own, numpy alone. Voxels are grouped in chunks, columns of the room, so that a viewer is sent only
those that changed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

VOXEL_M = 0.05
#: Edge (m) of a chunk's square on the floor.
CHUNK_M = 1.6
MOST_VOXELS = 120_000
#: A voxel that was seen so long ago (s) is a step darker; from the last on it is gone.
AGES_S = (8.0, 20.0, 40.0, 60.0)
_SHADES = (1.0, 0.72, 0.5, 0.34)
#: A voxel nearer than what is seen behind it by more than this (m) is not there any more.
_THROUGH_M = 0.3
#: Directions are counted in cells of this size (rad); a cell counts with so many points.
_CELL_RAD = 0.04
_LEAST_POINTS = 3
#: Cells of voxels from the origin, each way, that have indices of their own.
_REACH = 1 << 15
_CHUNK_CELLS = round(CHUNK_M / VOXEL_M)
#: A stamp (s) that lies back by more than this is of another time: a recording jumped.
_BACK_S = 1.0

Chunk = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class ChunkPoints:
    """Voxels of one chunk: middles (N, 3) float32, m in O; ``colors`` (N, 3) uint8; ``ranks`` (N,) float32 in [0, 1[:
    of a part, those with the least are shown."""

    points: NDArray[np.float32]
    colors: NDArray[np.uint8]
    ranks: NDArray[np.float32]


class VoxelMap:
    """For one thread."""

    def __init__(self) -> None:
        self._keys = np.zeros(0, np.int64)
        self._colors = np.zeros((0, 3), np.uint8)
        self._stamps = np.zeros(0, np.float64)
        self._ages = np.zeros(0, np.int8)
        self._versions: dict[Chunk, int] = {}
        self._changes = 0
        self._now = -np.inf

    def __len__(self) -> int:
        return len(self._keys)

    def add(
        self, points: NDArray[np.float32], colors: NDArray[np.uint8], eye: NDArray[np.float64], stamp: float
    ) -> None:
        """Take ``points`` (N, 3), m in O, with ``colors`` (N, 3), seen from ``eye`` (3,) at ``stamp`` (s)."""
        if stamp < self._now - _BACK_S:
            self.clear()
        self._now = max(self._now, stamp)
        finite = np.isfinite(points).all(axis=1) & (np.abs(points) < VOXEL_M * (_REACH - 1)).all(axis=1)
        points, colors = points[finite], colors[finite]
        gone = self._seen_through(points, eye)
        cells = np.floor(points / VOXEL_M).astype(np.int64)
        keys, first = np.unique(_key(cells), return_index=True)
        at = np.searchsorted(self._keys, keys)
        known = at < len(self._keys)
        known[known] = self._keys[at[known]] == keys[known]
        here = at[known]
        gone[here] = False
        self._colors[here] = colors[first[known]]
        self._stamps[here] = stamp
        # What was faded is bright again: that is a change; a new colour of the same place is not worth one.
        bright = here[self._ages[here] > 0]
        self._ages[here] = 0
        self._touch(self._keys[bright])
        self._touch(self._keys[gone])
        new = ~known
        self._touch(keys[new])
        kept = ~gone
        self._keys = np.concatenate([self._keys[kept], keys[new]])
        self._colors = np.concatenate([self._colors[kept], colors[first[new]]])
        self._stamps = np.concatenate([self._stamps[kept], np.full(int(new.sum()), stamp)])
        self._ages = np.concatenate([self._ages[kept], np.zeros(int(new.sum()), np.int8)])
        self._sort()
        self._bound()

    def fade(self, now: float) -> None:
        """Let voxels grow older up to ``now`` (s), and the oldest go."""
        self._now = max(self._now, now)
        ages = np.searchsorted(AGES_S, self._now - self._stamps, side="right").astype(np.int8)
        self._touch(self._keys[ages != self._ages])
        self._ages = ages
        self._keep(ages < len(AGES_S))
        there = {(x, y) for x, y in np.unique(_chunks(self._keys), axis=0).tolist()}
        self._versions = {chunk: version for chunk, version in self._versions.items() if chunk in there}

    def clear(self) -> None:
        """Forget all."""
        self._versions = {}
        self._keep(np.zeros(len(self._keys), np.bool_))
        self._now = -np.inf

    def versions(self) -> dict[Chunk, int]:
        """Of each chunk with voxels a number that grows whenever what is to be shown of it changes."""
        return self._versions

    def chunk(self, chunk: Chunk) -> ChunkPoints:
        """The voxels of ``chunk``, as they are to be shown."""
        x, y = (index * _CHUNK_CELLS for index in chunk)
        # Keys are sorted by x first.
        low, high = np.searchsorted(self._keys, [(x + _REACH) << 32, (x + _CHUNK_CELLS + _REACH) << 32])
        keys = self._keys[low:high]
        cells = _cells(keys)
        inside = (cells[:, 1] >= y) & (cells[:, 1] < y + _CHUNK_CELLS)
        shades = np.array(_SHADES)[self._ages[low:high][inside]]
        colors = (self._colors[low:high][inside] * shades[:, None]).astype(np.uint8)
        points = ((cells[inside] + 0.5) * VOXEL_M).astype(np.float32)
        return ChunkPoints(points, colors, _ranks(keys[inside]))

    def middles(self) -> NDArray[np.float32]:
        """The middles (N, 3) of all voxels, m in O."""
        return ((_cells(self._keys) + 0.5) * VOXEL_M).astype(np.float32)

    def _seen_through(self, points: NDArray[np.float32], eye: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which voxels (N,) bool lie before what is seen in their direction."""
        gone = np.zeros(len(self._keys), np.bool_)
        if len(points) == 0 or len(gone) == 0:
            return gone
        directions, ranges = _directions(points - eye)
        cells, index, counts = np.unique(directions, return_inverse=True, return_counts=True)
        nearest = np.full(len(cells), np.inf)
        np.minimum.at(nearest, index.reshape(-1), ranges)
        nearest[counts < _LEAST_POINTS] = 0.0
        of_voxels, distances = _directions((_cells(self._keys) + 0.5) * VOXEL_M - eye)
        at = np.minimum(np.searchsorted(cells, of_voxels), len(cells) - 1)
        return np.asarray((cells[at] == of_voxels) & (distances < nearest[at] - _THROUGH_M), np.bool_)

    def _touch(self, keys: NDArray[np.int64]) -> None:
        if len(keys) == 0:
            return
        self._changes += 1
        for x, y in np.unique(_chunks(keys), axis=0).tolist():
            self._versions[x, y] = self._changes

    def _sort(self) -> None:
        order = np.argsort(self._keys, kind="stable")
        self._keys, self._colors = self._keys[order], self._colors[order]
        self._stamps, self._ages = self._stamps[order], self._ages[order]

    def _bound(self) -> None:
        """The oldest go where there are too many."""
        excess = len(self._keys) - MOST_VOXELS
        if excess > 0:
            oldest = np.argpartition(self._stamps, excess)[:excess]
            kept = np.ones(len(self._keys), np.bool_)
            kept[oldest] = False
            self._touch(self._keys[oldest])
            self._keep(kept)

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        if not kept.all():
            self._keys, self._colors = self._keys[kept], self._colors[kept]
            self._stamps, self._ages = self._stamps[kept], self._ages[kept]


def _key(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number (N,) for each cell (N, 3), sorted by x, y, z."""
    x, y, z = (cells + _REACH).T
    return np.asarray((x << 32) | (y << 16) | z, np.int64)


def _cells(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([keys >> 32, (keys >> 16) & 0xFFFF, keys & 0xFFFF], axis=1) - _REACH


def _chunks(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """The chunk (N, 2) of each cell."""
    return _cells(keys)[:, :2] // _CHUNK_CELLS


def _ranks(keys: NDArray[np.int64]) -> NDArray[np.float32]:
    """Numbers in [0, 1[, one for each key, always the same, spread evenly without a pattern."""
    mixed = keys.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    return ((mixed >> np.uint64(41)).astype(np.float32) / np.float32(1 << 23)).astype(np.float32)


def _directions(rays: NDArray[np.floating]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """A number (N,) of the direction of each ray (N, 3), and its length (m)."""
    x, y, z = rays.T
    across = np.hypot(x, y)
    azimuth = np.floor(np.arctan2(y, x) / _CELL_RAD).astype(np.int64)
    elevation = np.floor(np.arctan2(z, across) / _CELL_RAD).astype(np.int64)
    return azimuth * 1024 + elevation, np.hypot(across, z).astype(np.float64)
