"""Maps to plan on: drawn by hand, or at random; and a body that goes there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostField
from app.modules.behaviors.navigation.planning.astar import explore
from app.robots.actuator_config import circle

ROUND = Footprint.polygon(np.array(circle(0.28)))
#: The Jackal's.
OBLONG = Footprint.polygon(np.array([[0.254, 0.215], [-0.254, 0.215], [-0.254, -0.215], [0.254, -0.215]]))

#: Four rooms along a corridor, tables in three of them; one letter is a quarter of a metre. The store has no door.
OFFICE = """
############################################################
#..............#...........#.................#.............#
#..............#...........#.................#.............#
#...####.......#...........#.................#.............#
#...####.......#.....##....#......######.....#.............#
#..............#.....##....#......######.....#.............#
#..............#.....##....#......######.....#....STORE....#
#..............#...........#.................#.............#
#..............#...........#.................#.............#
#..............#...........#.................#.............#
####.....######################.....########################
#..........................................................#
#..........................................................#
#..........................................................#
#..........................................................#
#..........................................................#
#..........................................................#
#..........................................................#
###########.....##############################.....#########
#..........................#...............................#
#..........................#....##########################.#
#..........................#....##########################.#
#...#########..............#...............................#
#...#########..............#...............................#
#..........................#...............................#
#..........................................................#
#..........................................................#
#..........................................................#
#..........................................................#
#..........................#...............................#
#..........................#...............................#
############################################################
"""


def grid_of(
    cells: NDArray[np.int8], resolution_m: float = 0.05, origin: tuple[float, float] = (0.0, 0.0), version: int = 0
) -> OccupancyGrid:
    """A map of ``cells`` (H, W), row 0 lowest."""
    return OccupancyGrid(0.0, "map", cells, resolution_m, origin, version)


def drawn(picture: str, letter_m: float = 0.25, resolution_m: float = 0.05) -> OccupancyGrid:
    """A map as drawn, the last line lowest: # occupied, ? unknown, else free."""
    lines = picture.strip().splitlines()[::-1]
    letters = np.array([list(line.ljust(max(map(len, lines)))) for line in lines])
    cells = np.select([letters == "#", letters == "?"], [100, -1], 0).astype(np.int8)
    each = round(letter_m / resolution_m)
    return grid_of(cells.repeat(each, axis=0).repeat(each, axis=1), resolution_m)


def office() -> OccupancyGrid:
    """OFFICE, 15 x 8 m."""
    return drawn(OFFICE)


def random_cells(seed: int, rows: int = 70, columns: int = 90) -> NDArray[np.int8]:
    """Walls, blocks and unknown patches at random."""
    rng = np.random.default_rng(seed)
    cells = np.zeros((rows, columns), dtype=np.int8)
    for _ in range(rng.integers(0, 4)):
        r, c = rng.integers(0, rows), rng.integers(0, columns)
        cells[r : r + rng.integers(1, 20), c : c + rng.integers(1, 20)] = -1
    for _ in range(rng.integers(0, 12)):
        r, c = rng.integers(0, rows), rng.integers(0, columns)
        if rng.random() < 0.5:
            cells[r : r + 1, c : c + rng.integers(1, columns)] = 100
        else:
            cells[r : r + rng.integers(1, rows), c : c + 1] = 100
    for _ in range(rng.integers(0, 6)):
        r, c = rng.integers(0, rows), rng.integers(0, columns)
        cells[r : r + 6, c : c + 9] = 100
    return cells


def lethal_along(field: CostField, poses: NDArray[np.float64], step_m: float = 0.002) -> int:
    """How many points of a way, looked at every ``step_m``, lie in lethal cells, their outermost 2 mm aside."""
    points = _sampled(poses, step_m)
    lethal = np.ones(len(points), dtype=bool)
    for dx, dy in ((0.002, 0.002), (0.002, -0.002), (-0.002, 0.002), (-0.002, -0.002)):
        cells, inside = field.frame.cells(points + np.array([dx, dy]))
        assert inside.all()
        lethal &= ~np.isfinite(field.cost[cells[:, 0], cells[:, 1]])
    return int(lethal.sum())


def cost_along(field: CostField, poses: NDArray[np.float64]) -> float:
    """Of a way, sampled every two millimetres or finer, in metres in the open."""
    points = _sampled(poses, 0.002)
    cells, _ = field.frame.cells(0.5 * (points[1:] + points[:-1]))
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return float((field.cost[cells[:, 0], cells[:, 1]] * lengths).sum())


def _sampled(poses: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    lengths = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1))))
    at = np.union1d(lengths, np.arange(0.0, lengths[-1], step_m))
    return np.stack((np.interp(at, lengths, poses[:, 0]), np.interp(at, lengths, poses[:, 1])), axis=-1)


def zone(kind: str, polygon: Sequence[tuple[float, float]], speed: float = 0.5, name: str = "") -> Zone:
    """A zone of the map, named after its kind if not otherwise."""
    return Zone(name or kind, kind, np.array(polygon, dtype=np.float64), speed)


def box(x0: float, y0: float, x1: float, y1: float) -> tuple[tuple[float, float], ...]:
    """The corners of an upright rectangle."""
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def free_place(field: CostField, random: Callable[[int], int]) -> Pose2 | None:
    """The middle of one of the cells that are not lethal."""
    rows, columns = np.nonzero(np.isfinite(field.cost))
    if not len(rows):
        return None
    k = random(len(rows))
    return Pose2(*field.frame.middle(int(rows[k]), int(columns[k])), math.nan)


def cheapest_way(field: CostField, start: tuple[int, int], goal: tuple[int, int]) -> NDArray[np.int64] | None:
    """Cells (N, 2) from ``start`` to ``goal`` as A* finds them; None: one of them is lethal, or there is no way."""
    if not (np.isfinite(field.cost[start]) and np.isfinite(field.cost[goal])):
        return None
    reached = explore(field, start, goal)
    return reached.way(goal) if reached.has(goal) else None
