"""Rays on an occupancy grid: what they meet, compared with a plain search cell by cell."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from app.maps.grid_rays import GridRays
from app.messages import OccupancyGrid

CELL_M = 0.05


def room(width_m: float = 6.0, height_m: float = 4.0, origin: tuple[float, float] = (-1.0, -2.0)) -> OccupancyGrid:
    """A room with walls of one cell, a square pillar in it, and a corner that is not known."""
    cells = np.zeros((round(height_m / CELL_M), round(width_m / CELL_M)), np.int8)
    cells[0], cells[-1], cells[:, 0], cells[:, -1] = 100, 100, 100, 100
    cells[36:44, 76:84] = 100
    cells[1:10, 1:10] = -1
    return OccupancyGrid(0.0, "map", cells, CELL_M, origin=origin, version=1)


def searched(grid: OccupancyGrid, x: float, y: float, direction: float) -> float:
    """The distance by steps of a tenth of a cell."""
    for step in range(10_000):
        away = step * CELL_M / 10
        column = math.floor((x + away * math.cos(direction) - grid.origin[0]) / CELL_M)
        row = math.floor((y + away * math.sin(direction) - grid.origin[1]) / CELL_M)
        height, width = grid.cells.shape
        if not (0 <= row < height and 0 <= column < width):
            return math.inf
        if grid.cells[row, column] >= 65:
            return away
    return math.inf


@given(
    x=st.floats(-0.9, 2.7), y=st.floats(-1.9, 1.9), directions=st.lists(st.floats(-3.1, 3.1), min_size=1, max_size=12)
)
@example(x=0.0, y=0.0, directions=[-5e-324])  # along the side between two cells, and a hair below it
def test_rays_meet_what_a_search_of_every_cell_meets(x: float, y: float, directions: list[float]) -> None:
    grid = room()
    cast = GridRays(grid).cast(x, y, np.array(directions), 30.0)
    for found, direction in zip(cast, directions, strict=True):
        slowly = searched(grid, x, y, direction)
        # A ray may pass the very corner of a cell, by less than half of one.
        beside = [searched(grid, x, y, direction + turn) for turn in (-0.02, 0.02)]
        assert any(abs(found - each) < 1.1 * CELL_M for each in (slowly, *beside))


def test_rays_end_at_their_reach_and_leave_the_grid_without_a_hit() -> None:
    rays = GridRays(room())
    east = np.array([0.0])
    assert rays.cast(0.0, 1.0, east, 30.0)[0] == pytest.approx(4.95, abs=CELL_M)
    assert math.isinf(rays.cast(0.0, 1.0, east, 4.0)[0])
    open_land = OccupancyGrid(0.0, "map", np.zeros((40, 40), np.int8), CELL_M, origin=(0.0, 0.0), version=1)
    assert math.isinf(GridRays(open_land).cast(1.0, 1.0, east, 30.0)[0])


def test_a_pillar_hides_what_is_behind_it() -> None:
    rays = GridRays(room())
    assert not rays.sees((2.0, 0.0), (4.5, 0.0))
    assert rays.sees((2.0, 0.0), (2.7, 0.0))
    assert rays.sees((2.0, 1.0), (4.5, 1.0))


def test_clearance_is_never_more_than_the_distance_to_an_obstacle() -> None:
    grid = room()
    rays, rng = GridRays(grid), np.random.default_rng(1)
    rows, columns = np.nonzero(grid.cells >= 65)
    middles = np.stack((columns + 0.5, rows + 0.5), axis=-1) * CELL_M + np.array(grid.origin)
    for x, y in rng.uniform((-0.9, -1.9), (4.9, 1.9), (200, 2)):
        nearest = np.abs(middles - (x, y)) - CELL_M / 2
        true_m = float(np.hypot(*np.maximum(nearest, 0.0).T).min())
        clear = rays.clear_m(x, y)
        assert clear <= true_m + 1e-9
        assert clear >= true_m - 3 * CELL_M
    assert rays.clear_m(100.0, 0.0) == 0.0


def test_points_in_occupied_cells_are_found_and_those_beyond_are_free() -> None:
    points = np.array([[3.0, 0.0], [0.0, 1.0], [100.0, 0.0], [-0.98, 0.0]])
    assert GridRays(room()).occupied(points).tolist() == [True, False, False, True]
