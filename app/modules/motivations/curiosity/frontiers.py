"""Frontiers of a map: where its free floor meets what is not known (Yamauchi 1997), and which to look at next. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from app.base.geometry import Pose2, wrap_angle
from app.maps.place_checks import OCCUPIED
from app.messages import OccupancyGrid, Zone

#: Cells of this occupancy (0 to 100) and less are free floor: what is between is not decided yet.
FREE = 35
#: A frontier is looked at from at most so far (m): further off, something bars the way to it.
_SEEN_FROM_M = 1.0
#: The robot may be so far (m) from where it fits: its map is not exact.
_OFF_M = 0.5
#: The unknown within this distance (m) of a frontier's nearest point says where to look.
_BEFORE_M = 1.0
#: Of a frontier's points whose ways differ by no more (m), the middle one is gone to.
_AS_NEAR_M = 0.5
#: Metres of way that a frontier's length (m), up to the other, and a turn towards it (rad) are worth.
_LENGTH_WORTH, _LONGEST_M = 0.5, 4.0
_TURN_WORTH = 0.4
#: Two frontiers nearer to each other (m) are the same one, seen again.
SAME_M = 0.8
#: Another frontier is chosen instead where its cost (m) is less by so much.
_BETTER_M = 2.0


@dataclass(frozen=True, slots=True)
class Frontier:
    """One stretch of border between free floor and unknown.

    ``x``, ``y`` (m on the map): of its points with about the shortest way the middle one. ``stand``: the pose on the
    map to look at it from, which the robot can reach and which faces the unknown. ``way_m``: length of the way there,
    to about 8 %.
    """

    x: float
    y: float
    length_m: float
    stand: Pose2
    way_m: float


@dataclass(frozen=True, slots=True)
class Refused:
    """A place, m on the map, at which a frontier could not be reached, ``times`` times."""

    x: float
    y: float
    times: int = 1


def frontiers(
    grid: OccupancyGrid, zones: Sequence[Zone], X_MB: Pose2, radius_m: float, least_m: float
) -> tuple[Frontier, ...]:
    """The frontiers of at least ``least_m`` that a disc of ``radius_m`` can reach from ``X_MB``, none in or beyond a
    keep-out zone."""
    grid = _framed(grid)
    cells, size = grid.cells, grid.resolution_m
    shut = _keep_out(grid, zones)
    unknown = (cells < 0) & ~shut
    free = (cells >= 0) & (cells <= FREE) & ~shut
    barred = (cells >= OCCUPIED) | shut
    clearance = cv2.distanceTransform(np.asarray(~barred, dtype=np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * size
    passable = free & (clearance > radius_m)
    start = _nearest(passable, _cell(grid, X_MB.x, X_MB.y), _OFF_M / size)
    if start is None:
        return ()
    ways = wavefront(passable, start)
    reached = np.isfinite(ways)
    # A border in a gap narrower than the body's radius belongs to what stands there, not to a room beyond.
    border = free & _beside(unknown) & (clearance > 0.5 * radius_m)
    beyond = unknown & _beside(border)
    away, nearest = ndimage.distance_transform_edt(~reached, return_indices=True)
    labels, count = ndimage.label(border, structure=np.ones((3, 3)))
    found = []
    for number, box in enumerate(ndimage.find_objects(labels, count), start=1):
        rows, columns = np.nonzero(labels[box] == number)
        length_m = rows.size * size
        if length_m < least_m:
            continue
        rows, columns = rows + box[0].start, columns + box[1].start
        distance = np.where(away[rows, columns] * size <= _SEEN_FROM_M, away[rows, columns], np.inf)
        way = ways[nearest[0, rows, columns], nearest[1, rows, columns]] + distance
        shortest = float(way.min())
        if not math.isfinite(shortest):
            continue
        # Of those about as near the middle one: a door is passed in its middle.
        near = np.flatnonzero(way <= shortest + _AS_NEAR_M / size)
        off = np.hypot(rows[near] - rows[near].mean(), columns[near] - columns[near].mean())
        at = near[int(np.argmin(off))]
        point = int(rows[at]), int(columns[at])
        stand = int(nearest[0][point]), int(nearest[1][point])
        x, y = _middle(grid, *point)
        found.append(Frontier(x, y, length_m, _facing(grid, beyond, stand, point), float(ways[stand]) * size))
    return tuple(found)


def choose(
    found: Sequence[Frontier], X_MB: Pose2, current: Frontier | None, refused: Sequence[Refused], tries: int
) -> Frontier | None:
    """The frontier to look at next; None where none is left that was refused fewer than ``tries`` times.

    A short way, a long frontier and one ahead are preferred, and those refused come last. ``current`` is kept while it
    is still there and no other is clearly better.
    """
    costs = {}
    for frontier in found:
        times = max((each.times for each in refused if _near(frontier, each)), default=0)
        if times < tries:
            bearing = math.atan2(frontier.y - X_MB.y, frontier.x - X_MB.x)
            turn = abs(wrap_angle(bearing - X_MB.theta))
            worth = _LENGTH_WORTH * min(frontier.length_m, _LONGEST_M)
            costs[frontier] = frontier.way_m - worth + _TURN_WORTH * turn + 1e3 * times
    if not costs:
        return None
    best = min(costs, key=lambda frontier: costs[frontier])
    if current is not None:
        same = [frontier for frontier in costs if _near(frontier, current)]
        if same:
            kept = min(same, key=lambda frontier: math.dist((frontier.x, frontier.y), (current.x, current.y)))
            if costs[best] > costs[kept] - _BETTER_M:
                return kept
    return best


def refuse(refused: Sequence[Refused], frontier: Frontier) -> tuple[Refused, ...]:
    """``refused``, with ``frontier`` refused once more."""
    times = 1 + max((each.times for each in refused if _near(frontier, each)), default=0)
    others = tuple(each for each in refused if not _near(frontier, each))
    return (*others, Refused(frontier.x, frontier.y, times))


def wavefront(passable: NDArray[np.bool_], start: tuple[int, int]) -> NDArray[np.float32]:
    """Lengths (cells) of ways through ``passable`` (H, W) from the cell ``start`` (row, column), infinite where none
    leads. Steps go straight and, every other one, diagonally, too: an octagon, at most 8 % off a circle."""
    ways = np.full(passable.shape, np.inf, dtype=np.float32)
    reached = np.zeros(passable.shape, dtype=np.uint8)
    reached[start] = 1
    ways[start] = 0.0
    shapes = (cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.ones((3, 3), np.uint8))
    step = still = 0
    while still < len(shapes):  # what only one of the two shapes reaches comes with the next step
        step += 1
        grown = cv2.dilate(reached, shapes[step % 2])
        new = (grown > reached) & passable
        still = 0 if new.any() else still + 1
        ways[new] = step
        reached[new] = 1
    return ways


def known_floor_m2(grid: OccupancyGrid) -> float:
    """Area (m²) of the free floor of ``grid``."""
    return float(np.count_nonzero((grid.cells >= 0) & (grid.cells <= FREE))) * grid.resolution_m**2


def _near(frontier: Frontier, other: Frontier | Refused) -> bool:
    return math.dist((frontier.x, frontier.y), (other.x, other.y)) <= SAME_M


def _framed(grid: OccupancyGrid) -> OccupancyGrid:
    """The part of ``grid`` that is known, with a cell of unknown all around: beyond a map is what it does not have."""
    rows, columns = (np.flatnonzero((grid.cells >= 0).any(axis=axis)) for axis in (1, 0))
    if rows.size == 0:
        return grid
    (x, y), size = grid.origin, grid.resolution_m
    known = grid.cells[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    origin = x + (int(columns[0]) - 1) * size, y + (int(rows[0]) - 1) * size
    return replace(grid, cells=np.pad(known, 1, constant_values=-1), origin=origin)


def _keep_out(grid: OccupancyGrid, zones: Sequence[Zone]) -> NDArray[np.bool_]:
    shut = np.zeros(grid.cells.shape, dtype=np.uint8)
    for zone in zones:
        if zone.kind == "keep_out":
            corners = (zone.polygon - np.array(grid.origin)) / grid.resolution_m - 0.5
            outline = np.rint(np.clip(corners, -1e6, 1e6)).astype(np.int32)[None]
            cv2.fillPoly(shut, [outline], 1)
            cv2.polylines(shut, [outline], isClosed=True, color=1)
    return shut.astype(np.bool_)


def _cell(grid: OccupancyGrid, x: float, y: float) -> tuple[int, int]:
    row, column = (y - grid.origin[1]) / grid.resolution_m, (x - grid.origin[0]) / grid.resolution_m
    return math.floor(row), math.floor(column)


def _middle(grid: OccupancyGrid, row: float, column: float) -> tuple[float, float]:
    return grid.origin[0] + (column + 0.5) * grid.resolution_m, grid.origin[1] + (row + 0.5) * grid.resolution_m


def _nearest(passable: NDArray[np.bool_], cell: tuple[int, int], within: float) -> tuple[int, int] | None:
    """The cell of ``passable`` that is nearest to ``cell``, if ``within`` so many."""
    low = [max(0, math.floor(value - within)) for value in cell]
    high = [max(0, math.ceil(value + within) + 1) for value in cell]
    rows, columns = np.nonzero(passable[low[0] : high[0], low[1] : high[1]])
    if rows.size == 0:
        return None
    rows, columns = rows + low[0], columns + low[1]
    away = np.hypot(rows - cell[0], columns - cell[1])
    at = int(np.argmin(away))
    return (int(rows[at]), int(columns[at])) if away[at] <= within else None


def _beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The cells next to any of ``cells`` or among them."""
    return np.asarray(cv2.dilate(cells.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)


def _facing(grid: OccupancyGrid, beyond: NDArray[np.bool_], stand: tuple[int, int], point: tuple[int, int]) -> Pose2:
    """The pose at the cell ``stand`` that faces the unknown cells ``beyond`` the frontier around its ``point``."""
    reach = round(_BEFORE_M / grid.resolution_m)
    low = max(0, point[0] - reach), max(0, point[1] - reach)
    rows, columns = np.nonzero(beyond[low[0] : point[0] + reach + 1, low[1] : point[1] + reach + 1])
    x, y = _middle(grid, *stand)
    at_x, at_y = _middle(grid, float(rows.mean()) + low[0], float(columns.mean()) + low[1])
    return Pose2(x, y, math.atan2(at_y - y, at_x - x))
