"""From messages to what is drawn: pure functions on arrays."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan

#: Laser points go from red at the robot to blue this far ahead of it (m).
FAR_M = 8.0
_RED = np.array([255.0, 48.0, 32.0])
_BLUE = np.array([40.0, 90.0, 255.0])


def scan_points(scan: LaserScan) -> NDArray[np.float32]:
    """The hits of a scan as points (N, 3) float32, m, in ``base_link`` at its stamp."""
    hit = np.isfinite(scan.ranges) & (scan.ranges >= scan.range_min) & (scan.ranges <= scan.range_max)
    ranges = scan.ranges[hit]
    angles = (scan.angle_min + scan.angle_increment * np.flatnonzero(hit)).astype(np.float32)
    points = np.zeros((len(ranges), 3), np.float32)
    points[:, 0] = ranges * np.cos(angles)
    points[:, 1] = ranges * np.sin(angles)
    return np.asarray(scan.X_BL.transform(points), np.float32)


def colors_along_x(points: NDArray[Any]) -> NDArray[np.uint8]:
    """Colours (N, 3) uint8 of ``points`` (N, 3) in ``base_link``: red at the robot, blue :data:`FAR_M` ahead."""
    far = np.clip(points[:, :1].astype(np.float64) / FAR_M, 0.0, 1.0)
    return np.asarray(_RED + far * (_BLUE - _RED), np.uint8)


def thinned(count: int, most: int) -> NDArray[np.intp]:
    """Indices of at most ``most`` of ``count`` points, spread evenly but without a pattern, ascending.

    Always the same for the same numbers; those for fewer are among those for more.
    """
    if count <= most:
        return np.arange(count, dtype=np.intp)
    order = spread_order((count - 1).bit_length())
    kept = np.zeros(count, np.bool_)
    kept[order[order < count][:most]] = True
    return np.flatnonzero(kept)


@lru_cache(maxsize=32)
def spread_order(bits: int) -> NDArray[np.intp]:
    """The numbers below 2**``bits`` in an order of which every beginning is spread evenly over them.

    Van der Corput's sequence with Owen's scrambling: whenever 2**k numbers more have come, one more has come of each
    of 2**k equal stretches, from anywhere in it. Numbers at even steps would meet the rows of an image as a moiré.
    """
    random = np.random.default_rng(bits)
    order = np.zeros(1, np.intp)
    for _ in range(bits):
        half = random.integers(0, 2, len(order))
        order = np.concatenate([2 * order + half, 2 * order + 1 - half])
    order.flags.writeable = False
    return order


def point_size(count: int) -> float:
    """Size (m) at which ``count`` points cover a view alike, in steps, so that it seldom changes."""
    size = 0.016 * math.sqrt(19_200 / max(count, 1))
    return min(max(round(size / 0.006) * 0.006, 0.012), 0.06)


def pose_arrays(pose: Pose2) -> tuple[tuple[float, float, float, float], tuple[float, float, float]]:
    """Orientation (w, x, y, z) and position (x, y, z) of a planar pose."""
    half = 0.5 * pose.theta
    return (math.cos(half), 0.0, 0.0, math.sin(half)), (pose.x, pose.y, 0.0)


def moved(before: Pose2 | None, now: Pose2) -> bool:
    """Whether a pose differs by what an eye could see: 1 mm or 0.05°."""
    if before is None:
        return True
    turn = abs(math.remainder(now.theta - before.theta, math.tau))
    return math.hypot(now.x - before.x, now.y - before.y) > 1e-3 or turn > 1e-3
