"""Places of straight walls, and what a laser sees of them: for tests that need no world."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import LaserScan, OccupancyGrid, read_only

Segment = tuple[tuple[float, float], tuple[float, float]]
#: As the lab's: 720 rays over a half circle, 0.2 m before the base's middle.
X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))
ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 720)


def polygon(*corners: tuple[float, float]) -> list[Segment]:
    """The walls between ``corners``, closed."""
    return list(zip(corners, (*corners[1:], corners[0]), strict=True))


def box(x: float, y: float, width: float, depth: float) -> list[Segment]:
    """Four walls, the lower left corner at x, y."""
    return polygon((x, y), (x + width, y), (x + width, y + depth), (x, y + depth))


#: A hall of 12 x 8 m with two rooms, a pillar and a cupboard: no place in it looks like another.
HALL: list[Segment] = [
    *polygon((0, 0), (12, 0), (12, 8), (0, 8)),
    ((0, 5), (3, 5)),
    ((4.2, 5), (7, 5)),
    ((7, 5), (7, 8)),
    *box(9, 2, 0.4, 0.4),
    *box(2, 1, 1.2, 0.6),
    ((12, 3.5), (9.8, 3.5)),
]


def ranges(
    walls: Sequence[Segment], x: float, y: float, angles: NDArray[np.float64], most: float
) -> NDArray[np.float64]:
    """How far each of ``angles`` (world) from x, y the next wall is; infinite beyond ``most``."""
    a = np.array([w[0] for w in walls], np.float64)
    along = np.array([w[1] for w in walls], np.float64) - a
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    ax, ay = a[:, 0] - x, a[:, 1] - y
    across = c * along[:, 1] - s * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (ax * along[:, 1] - ay * along[:, 0]) / across
        at = (ax * s - ay * c) / across
    far = np.where((far > 0) & (at >= 0) & (at <= 1), far, np.inf).min(axis=1)
    return np.where(far <= most, far, np.inf)


def scan(
    walls: Sequence[Segment],
    X_WB: Pose2,
    stamp: float = 0.0,
    *,
    noise_m: float = 0.01,
    seed: int = 0,
    angles: NDArray[np.float64] = ANGLES,
    most: float = 30.0,
) -> LaserScan:
    """What the laser of a body at ``X_WB`` sees."""
    offset = float(X_BL.translation[0])
    x, y = X_WB.x + offset * math.cos(X_WB.theta), X_WB.y + offset * math.sin(X_WB.theta)
    seen = ranges(walls, x, y, angles + X_WB.theta, most)
    seen = seen + np.random.default_rng(seed).normal(0.0, noise_m, len(seen))
    values = read_only(seen.astype(np.float32))
    increment = float(angles[1] - angles[0])
    return LaserScan(
        stamp, "laser", values, read_only(np.ones_like(values)), float(angles[0]), increment, 0.1, most, 0.0, X_BL
    )


def way(*corners: tuple[float, float], step_m: float = 0.1, step_rad: float = 0.1) -> list[Pose2]:
    """Poses along straight lines between ``corners``, turning on the spot at each."""
    poses: list[Pose2] = []
    theta = math.atan2(corners[1][1] - corners[0][1], corners[1][0] - corners[0][0])
    for (x, y), (u, v) in pairwise(corners):
        heading = math.atan2(v - y, u - x)
        turn = math.remainder(heading - theta, math.tau)
        turns = math.ceil(abs(turn) / step_rad)
        poses.extend(Pose2(x, y, theta + turn * n / turns) for n in range(1, turns + 1))
        theta = heading
        steps = max(1, math.ceil(math.dist((x, y), (u, v)) / step_m))
        poses.extend(Pose2(x + (u - x) * n / steps, y + (v - y) * n / steps, theta) for n in range(steps + 1))
    return poses


def drawn(
    walls: Iterable[Segment], size: tuple[float, float], cell_m: float = 0.05, margin_m: float = 0.5
) -> OccupancyGrid:
    """The true grid of a place: walls occupied, everything else inside ``size`` free."""
    width, height = (round((side + 2 * margin_m) / cell_m) for side in size)
    inside = round(margin_m / cell_m)
    cells = np.full((height, width), -1, np.int8)
    cells[inside:-inside, inside:-inside] = 0
    for (x, y), (u, v) in walls:
        for share in np.linspace(0, 1, max(2, math.ceil(math.dist((x, y), (u, v)) / cell_m * 3))):
            column = math.floor((x + share * (u - x) + margin_m) / cell_m)
            row = math.floor((y + share * (v - y) + margin_m) / cell_m)
            cells[row, column] = 100
    return OccupancyGrid(0.0, "map", read_only(cells), cell_m, (-margin_m, -margin_m), 1)
