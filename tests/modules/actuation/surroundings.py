"""Scans of simple surroundings, for tests of the collision monitor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

from app.base.geometry import Pose3
from app.messages import LaserScan

#: Half the field of view of the robot's own laser (rad), and where that is.
HALF_RAD = math.pi / 2
X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))


def scan(
    stamp: float,
    points: Iterable[tuple[float, float]] = (),
    *,
    width_m: float = 0.1,
    half_rad: float = HALF_RAD,
    rays: int = 720,
    X_BL: Pose3 = X_BL,
) -> LaserScan:
    """Round things of ``width_m`` with their nearest points at ``points`` (m in ``base_link``); nothing else."""
    radius = width_m / 2
    cx, cy = float(X_BL.translation[0]), float(X_BL.translation[1])
    centres = []
    for x, y in points:
        away = math.hypot(x - cx, y - cy)
        centres.append(((x - cx) * (1 + radius / away), (y - cy) * (1 + radius / away)))

    def ranges(angles: np.ndarray) -> np.ndarray:
        nearest = np.full(angles.shape, np.inf)
        for x, y in centres:
            along = x * np.cos(angles) + y * np.sin(angles)
            room = radius**2 - (x * x + y * y - along**2)
            hit = (room >= 0) & (along > 0)
            nearest = np.where(hit, np.minimum(nearest, along - np.sqrt(np.maximum(room, 0))), nearest)
        return nearest

    return of_ranges(stamp, ranges, half_rad=half_rad, rays=rays, X_BL=X_BL)


def wall(stamp: float, ahead_m: float) -> LaserScan:
    """A wall across the way, ``ahead_m`` before ``base_link``."""
    return of_ranges(stamp, lambda angles: (ahead_m - 0.2) / np.maximum(np.cos(angles), 1e-6))


def passage(stamp: float, width_m: float) -> LaserScan:
    """Walls on both sides, as far as the laser sees."""
    return of_ranges(stamp, lambda angles: width_m / 2 / np.maximum(np.abs(np.sin(angles)), 1e-6))


def of_ranges(
    stamp: float,
    ranges: Callable[[np.ndarray], np.ndarray],
    *,
    half_rad: float = HALF_RAD,
    rays: int = 720,
    X_BL: Pose3 = X_BL,
) -> LaserScan:
    """What the laser sees whose ray at each angle (rad, about its own x axis) meets something at ``ranges`` (m)."""
    angles = np.linspace(-half_rad, half_rad, rays)
    seen = ranges(angles)
    seen = np.where((seen >= 0.1) & (seen <= 30.0), seen, np.inf).astype(np.float32)
    return LaserScan(stamp, "laser", seen, seen, -half_rad, 2 * half_rad / (rays - 1), 0.1, 30.0, 0.0, X_BL)
