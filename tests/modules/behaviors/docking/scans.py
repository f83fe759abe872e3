"""Laser scans of docks and walls: rays against segments."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.behaviors.docking.dock_detector import DockShape

Floats = NDArray[np.float64]
Segment = tuple[tuple[float, float], tuple[float, float]]

SHAPE = DockShape()
#: Rays of the Hokuyo, and how far it is ahead of base_link.
ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 720)
AHEAD_M = 0.2


def plates(X_BD: Pose2, shape: DockShape = SHAPE) -> list[Segment]:
    """The two plates of a dock at ``X_BD``."""
    half = shape.opening_rad / 2
    tips = np.array([[math.cos(a), math.sin(a)] for a in (half, -half)]) * shape.plate_m
    left, right = X_BD.transform(tips)
    origin = (X_BD.x, X_BD.y)
    return [(origin, (float(left[0]), float(left[1]))), (origin, (float(right[0]), float(right[1])))]


def seen(segments: Sequence[Segment], rng: np.random.Generator, noise_m: float = 0.01) -> Floats:
    """Points (N, 2) m in ``base_link`` that the laser sees of ``segments``."""
    ranges = np.full(len(ANGLES), np.inf)
    directions = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
    for begin, end in segments:
        a, edge = np.array(begin) - [AHEAD_M, 0.0], np.array(end) - np.array(begin)
        across = directions[:, 0] * edge[1] - directions[:, 1] * edge[0]
        across = np.where(np.abs(across) < 1e-12, 1e-12, across)
        t = (a[0] * edge[1] - a[1] * edge[0]) / across
        u = (a[0] * directions[:, 1] - a[1] * directions[:, 0]) / across
        ranges = np.where((t > 0) & (u >= 0) & (u <= 1) & (t < ranges), t, ranges)
    hit = np.isfinite(ranges)
    measured = ranges[hit] + rng.normal(0, noise_m, int(hit.sum()))
    return np.asarray(measured[:, None] * directions[hit] + np.array([AHEAD_M, 0.0]))
