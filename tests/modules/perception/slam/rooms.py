"""Places made of walls, and what a laser sees of them: exact, but for the noise that is asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.offline_mapping import Sweep
from app.modules.perception.slam.scans import BeamGeometry

Walls = NDArray[np.float64]
RANGE_MAX_M = 30.0


def half_circle(rays: int = 181) -> BeamGeometry:
    """A laser that looks 180° ahead."""
    return BeamGeometry(np.linspace(-math.pi / 2, math.pi / 2, rays), 0.05, RANGE_MAX_M)


def box(left: float, low: float, right: float, high: float) -> list[tuple[float, float, float, float]]:
    """The four walls of a box: x0, y0, x1, y1 (m) each."""
    return [(left, low, right, low), (right, low, right, high), (right, high, left, high), (left, high, left, low)]


def room() -> Walls:
    """10 x 7 m with furniture, like nothing else."""
    return np.array([*box(-5, -3, 5, 4), *box(2, -1, 3.2, 0.5), *box(-4.5, 2.2, -3.1, 3.6), *box(-1, -2.5, 0.4, -2)])


def corridor() -> Walls:
    """Two straight walls, 2.4 m apart, longer than a laser sees."""
    return np.array([(-80.0, -1.2, 80.0, -1.2), (80.0, 1.2, -80.0, 1.2)])


def ring(side: float = 18.0, width: float = 2.5, seed: int = 3) -> Walls:
    """A corridor around a block, with pillars here and there along its walls."""
    rng = np.random.default_rng(seed)
    inner, outer = side / 2, side / 2 + width
    walls = [*box(-inner, -inner, inner, inner), *box(-outer, -outer, outer, outer)]
    for turn in range(4):
        c, s = math.cos(turn * math.pi / 2), math.sin(turn * math.pi / 2)
        for along in np.arange(-inner, inner, 1.4) + rng.uniform(0, 1.0, len(np.arange(-inner, inner, 1.4))):
            depth, breadth = rng.uniform(0.15, 0.5), rng.uniform(0.15, 0.5)
            at = outer if rng.random() < 0.5 else inner + depth
            corners = [(at - depth, along), (at, along), (at, along + breadth), (at - depth, along + breadth)]
            turned = [(c * x - s * y, s * x + c * y) for x, y in corners]
            walls += [(*turned[k], *turned[(k + 1) % 4]) for k in range(4)]
    return np.array(walls)


def seen(walls: Walls, beams: BeamGeometry, poses: Sequence[Pose2] | Pose2) -> NDArray[np.float64]:
    """Ranges (N,) m of all ``beams``, each from its own pose (or all from one); inf where nothing is near enough."""
    each = [poses] * len(beams.angles) if isinstance(poses, Pose2) else poses
    lasers = [pose @ beams.X_BL for pose in each]
    sensors_xy = np.array([(p.x, p.y) for p in lasers])
    angles = np.array([p.theta for p in lasers]) + beams.angles
    direction = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    start, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    to = start[None] - sensors_xy[:, None]
    across = direction[:, None, 0] * along[None, :, 1] - direction[:, None, 1] * along[None, :, 0]
    across = np.where(np.abs(across) < 1e-12, 1e-12, across)
    distance = (to[..., 0] * along[None, :, 1] - to[..., 1] * along[None, :, 0]) / across
    share = (to[..., 0] * direction[:, None, 1] - to[..., 1] * direction[:, None, 0]) / across
    distance = np.where((share >= 0) & (share <= 1) & (distance > 1e-6), distance, np.inf)
    nearest = distance.min(axis=1)
    return np.where(nearest < beams.range_max, nearest, np.inf)


def around(side: float, step: float = 0.15, laps: float = 1.0) -> list[Pose2]:
    """A way around a ring's middle line, corners turned on the spot."""
    poses: list[Pose2] = []
    half = side / 2
    legs = round(4 * laps)
    x, y, theta = half, -half, math.pi / 2
    for _ in range(legs):
        count = round(side / step)
        for k in range(count):
            share = side * k / count
            poses.append(Pose2(x + share * math.cos(theta), y + share * math.sin(theta), theta))
        x, y = x + side * math.cos(theta), y + side * math.sin(theta)
        poses += [Pose2(x, y, theta + turn) for turn in np.linspace(0, math.pi / 2, 12)[:-1]]
        theta += math.pi / 2
    return poses


def driven(
    walls: Walls,
    poses: Sequence[Pose2],
    beams: BeamGeometry,
    *,
    noise_m: float = 0.01,
    slip: float = 0.03,
    seed: int = 0,
) -> Iterator[Sweep]:
    """The sweeps of a drive along ``poses``; odometry is too long by ``slip``, turns as much too little, and shakes."""
    rng = np.random.default_rng(seed)
    X_OB = Pose2()
    for k, pose in enumerate(poses):
        if k:
            step = poses[k - 1].inverse() @ pose
            shaken = rng.normal(0.0, (0.005, 0.005, 0.003))
            X_OB = X_OB @ Pose2(
                step.x * (1 + slip) + shaken[0], step.y + shaken[1], step.theta * (1 - slip) + shaken[2]
            )
        ranges = seen(walls, beams, pose) + rng.normal(0.0, noise_m, len(beams.angles))
        yield Sweep(0.2 * k, ranges, beams, X_OB)
