"""Squareness of a mapped building: a measure of which of two trajectories is the truer, without ground truth.

Every scan sees pieces of walls, and its pose says which way they run. Most buildings have two families of walls, at a
right angle: what the trajectory makes of that angle, and how far its walls stray from the two, are its own errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: A piece of a wall is so many rays in a row, no farther away (m), ...
_RAYS = 9
_FAR_M = 10.0
#: ... so long (m) and so straight (m, rms) at least; taken from one ray in three.
_LONG_M = 0.25
_STRAIGHT_M = 0.012
_EVERY = 3
#: What strays farther than this (rad) from both families is no wall of them.
_ASTRAY_RAD = math.radians(6.0)


@dataclass(frozen=True, slots=True)
class Squareness:
    """``skew_deg``: how far the two families are from a right angle; ``astray_deg``: median distance of a piece of a
    wall from its family's common direction; of ``pieces``."""

    skew_deg: float
    astray_deg: float
    pieces: int


def wall_pieces(ranges: NDArray[np.floating], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 2) direction (rad, in the laser's frame) and length (m) of the pieces of walls in one scan (B,) m."""
    near = np.where(ranges <= _FAR_M, ranges, np.nan)
    points = np.stack((near * np.cos(angles), near * np.sin(angles)), axis=1)
    found = []
    for first in range(0, len(ranges) - _RAYS, _EVERY):
        row = points[first : first + _RAYS]
        if np.isnan(row).any():
            continue
        length = float(np.hypot(*(row[-1] - row[0])))
        _, singular, axes = np.linalg.svd(row - row.mean(axis=0))
        if length >= _LONG_M and singular[1] <= _STRAIGHT_M * math.sqrt(_RAYS):
            found.append((math.atan2(axes[0, 1], axes[0, 0]), length))
    return np.array(found).reshape(-1, 2)


def squareness(headings: NDArray[np.float64], pieces: list[NDArray[np.float64]]) -> Squareness:
    """Of a trajectory's ``headings`` (K,) rad of the scans with these ``pieces`` (K arrays, :func:`wall_pieces`)."""
    seen = np.concatenate([np.array((heading, 0.0)) + piece for heading, piece in zip(headings, pieces, strict=True)])
    directions, lengths = seen.T
    common = float(np.angle((lengths * np.exp(4j * directions)).sum())) / 4.0
    quarter = 0.5 * math.pi
    families = np.round((directions - common) / quarter)
    off = directions - common - quarter * families
    walls = np.abs(off) <= _ASTRAY_RAD
    first, second = (walls & (families % 2 == family) for family in (0, 1))
    means = [float(np.average(off[family], weights=lengths[family])) for family in (first, second)]
    return Squareness(
        math.degrees(abs(means[1] - means[0])), math.degrees(float(np.median(np.abs(off[walls])))), int(walls.sum())
    )
