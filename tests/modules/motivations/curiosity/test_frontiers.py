"""Frontiers: where they are, which is chosen, and that following them maps a floor wholly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.messages import OccupancyGrid, Zone
from app.modules.motivations.curiosity.frontiers import (
    Frontier,
    Refused,
    choose,
    frontiers,
    known_floor_m2,
    refuse,
    wavefront,
)

CELL_M, RADIUS_M, LEAST_M = 0.1, 0.3, 0.4
#: Two rooms of 4 x 4 m with a door of 1 m between them, 40 cells each, and walls of 2 cells.
ROOM, WALL, DOOR = 40, 2, 10


def floor(rooms_wide: int, rooms_high: int, doors: frozenset[tuple[int, int, str]]) -> NDArray[np.int8]:
    """Rooms in rows, walls (100) around each; ``doors``: (column, row, "right" or "up") of those that are open."""
    pitch = ROOM + WALL
    cells = np.full((rooms_high * pitch + WALL, rooms_wide * pitch + WALL), 100, np.int8)
    for row in range(rooms_high):
        for column in range(rooms_wide):
            x, y = WALL + column * pitch, WALL + row * pitch
            cells[y : y + ROOM, x : x + ROOM] = 0
            middle = (ROOM - DOOR) // 2
            if (column, row, "right") in doors and column + 1 < rooms_wide:
                cells[y + middle : y + middle + DOOR, x + ROOM : x + ROOM + WALL] = 0
            if (column, row, "up") in doors and row + 1 < rooms_high:
                cells[y + ROOM : y + ROOM + WALL, x + middle : x + middle + DOOR] = 0
    return cells


def grid_of(cells: NDArray[np.int8]) -> OccupancyGrid:
    return OccupancyGrid(1.0, "map", cells, CELL_M, (-1.0, 2.0), 1)


def at(row: float, column: float, theta: float = 0.0) -> Pose2:
    """The pose at a cell of :func:`grid_of`."""
    return Pose2(-1.0 + (column + 0.5) * CELL_M, 2.0 + (row + 0.5) * CELL_M, theta)


def half_known() -> NDArray[np.int8]:
    """The left room of two is known, and the door."""
    cells = floor(2, 1, frozenset({(0, 0, "right")}))
    cells[:, WALL + ROOM + WALL - 1 :] = -1
    return cells


def found_in(cells: NDArray[np.int8], X_MB: Pose2, zones: tuple[Zone, ...] = ()) -> tuple[Frontier, ...]:
    return frontiers(grid_of(cells), zones, X_MB, RADIUS_M, LEAST_M)


def test_a_door_to_what_is_not_known_is_the_one_frontier_and_is_looked_through() -> None:
    (door,) = found_in(half_known(), at(20, 10))
    middle = at(WALL + ROOM / 2, WALL + ROOM)
    assert math.dist((door.x, door.y), (middle.x, middle.y)) < 0.5
    assert 0.4 <= door.length_m <= 1.0
    assert abs(wrap_angle(door.stand.theta)) < 0.5, "it faces right"
    assert door.way_m == pytest.approx(math.dist((door.stand.x, door.stand.y), (at(20, 10).x, at(20, 10).y)), rel=0.1)


def test_what_is_shut_too_narrow_or_known_is_no_frontier() -> None:
    cells = half_known()
    door = at(WALL + ROOM / 2, WALL + ROOM)
    square = np.array([(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)]) + np.array([door.x, door.y])
    assert found_in(cells, at(20, 10), (Zone("lab", "keep_out", square, 1.0),)) == ()
    assert len(found_in(cells, at(20, 10), (Zone("lab", "slow", square, 0.5),))) == 1
    narrow = cells.copy()
    narrow[:, WALL + ROOM : WALL + ROOM + WALL] = 100
    narrow[20:22, WALL + ROOM : WALL + ROOM + WALL] = 0
    assert found_in(narrow, at(20, 10)) == (), "a gap of 0.2 m"
    assert found_in(floor(2, 1, frozenset({(0, 0, "right")})), at(20, 10)) == (), "all is known"
    assert found_in(np.full((5, 5), -1, np.int8), Pose2()) == (), "nothing is known"
    assert found_in(cells, Pose2(90.0, -90.0)) == (), "the robot is nowhere near"


def test_the_edge_of_the_grid_borders_on_the_unknown() -> None:
    assert len(found_in(np.zeros((30, 30), np.int8), at(15, 15))) == 1


HERE = Pose2(0.0, 0.0, 0.0)


def frontier(x: float, y: float, length_m: float = 1.0) -> Frontier:
    return Frontier(x, y, length_m, Pose2(x, y, 0.0), math.hypot(x, y))


def test_near_long_and_ahead_is_preferred() -> None:
    assert choose([frontier(5, 0), frontier(2, 0)], HERE, None, (), 2) == frontier(2, 0)
    assert choose([frontier(2, 0), frontier(2.1, 0.5, 3.0)], HERE, None, (), 2) == frontier(2.1, 0.5, 3.0)
    assert choose([frontier(-2, 0), frontier(2.2, 0)], HERE, None, (), 2) == frontier(2.2, 0)
    assert choose([], HERE, frontier(1, 0), (), 2) is None


def test_the_one_gone_to_is_kept_until_another_is_clearly_better() -> None:
    current = frontier(4, 0)
    seen_again = frontier(4.3, 0.2)
    assert choose([seen_again, frontier(3, 0)], HERE, current, (), 2) == seen_again
    assert choose([seen_again, frontier(1, 0)], HERE, current, (), 2) == frontier(1, 0)
    assert choose([frontier(8, 0), frontier(3, 0)], HERE, current, (), 2) == frontier(3, 0), "it is seen"


def test_one_that_could_not_be_reached_comes_last_and_not_for_ever() -> None:
    near, far = frontier(1, 0), frontier(9, 0)
    once = refuse((), near)
    assert once == (Refused(1, 0, 1),)
    assert choose([near, far], HERE, None, once, 2) == far
    assert choose([near], HERE, None, once, 2) == near
    twice = refuse(once, frontier(1.2, 0.1))
    assert [each.times for each in twice] == [2]
    assert choose([near], HERE, None, twice, 2) is None


@given(st.lists(st.tuples(st.integers(0, 19), st.integers(0, 19)), max_size=120), st.integers(0, 399))
@settings(max_examples=40)
def test_ways_reach_what_is_connected_and_are_no_shorter_than_the_line(
    walls: list[tuple[int, int]], start: int
) -> None:
    passable = np.ones((20, 20), bool)
    for row, column in walls:
        passable[row, column] = False
    here = divmod(start, 20)
    passable[here] = True
    ways = wavefront(passable, here)
    seen, edge = {here}, [here]
    while edge:  # by hand
        row, column = edge.pop()
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                cell = row + down, column + right
                if max(cell) < 20 and min(cell) >= 0 and passable[cell] and cell not in seen:
                    seen.add(cell)
                    edge.append(cell)
    assert {(int(row), int(column)) for row, column in np.argwhere(np.isfinite(ways))} == seen
    for cell in seen:
        assert ways[cell] >= 0.92 * math.dist(cell, here) - 1.0


def seen_from(cells: NDArray[np.int8], row: int, column: int, reach: int = 60) -> NDArray[np.bool_]:
    """The cells that rays from a cell pass, and those that stop them."""
    angles = np.linspace(0, 2 * math.pi, 720, endpoint=False)
    seen = np.zeros(cells.shape, bool)
    going = np.ones(angles.size, bool)
    for step in range(2 * reach):
        rows = np.rint(row + 0.5 * step * np.sin(angles)).astype(int)
        columns = np.rint(column + 0.5 * step * np.cos(angles)).astype(int)
        inside = going & (rows >= 0) & (columns >= 0) & (rows < cells.shape[0]) & (columns < cells.shape[1])
        seen[rows[inside], columns[inside]] = True
        going = inside.copy()
        going[inside] = cells[rows[inside], columns[inside]] == 0
    return seen


DOORS = [(column, row, way) for column in range(3) for row in range(2) for way in ("right", "up")]


@given(st.sets(st.sampled_from(DOORS)).map(frozenset), st.integers(0, 2), st.integers(0, 1))
@settings(max_examples=15)
def test_going_from_frontier_to_frontier_maps_every_room_that_a_door_leads_to(
    doors: frozenset[tuple[int, int, str]], column: int, row: int
) -> None:
    truth = floor(3, 2, doors)
    here = WALL + ROOM // 3 + row * (ROOM + WALL), WALL + ROOM // 3 + column * (ROOM + WALL)
    known = np.full(truth.shape, -1, np.int8)
    current: Frontier | None = None
    refused: tuple[Refused, ...] = ()
    for _ in range(60):
        sees = seen_from(truth, *here)
        known[sees] = truth[sees]
        pose = at(*here)
        found = found_in(known, pose)
        current = choose(found, pose, current, refused, 2)
        if current is None:
            break
        then = round((current.stand.y - 2.0) / CELL_M - 0.5), round((current.stand.x + 1.0) / CELL_M - 0.5)
        if then == here:
            refused = refuse(refused, current)
        here = then
    assert current is None, "it ends"
    reached = np.isfinite(wavefront(truth == 0, here))
    assert known_floor_m2(grid_of(known)) >= 0.97 * np.count_nonzero(reached) * CELL_M**2
