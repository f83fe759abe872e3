from __future__ import annotations

import heapq
import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostField, CostSettings, cost_field
from tests.modules.behaviors.navigation.maps import cheapest_way, grid_of, random_cells

#: So small that narrow gaps and single cells matter.
SMALL = Footprint.polygon(np.array([[0.05, -0.05], [0.05, 0.05], [-0.05, 0.05], [-0.05, -0.05]]))


def field_of(seed: int, origin: tuple[float, float] = (0.0, 0.0)) -> CostField:
    return cost_field(grid_of(random_cells(seed), origin=origin), SMALL, settings=CostSettings(reach_m=0.3))


def ends(field: CostField, seed: int) -> tuple[tuple[int, int], tuple[int, int]]:
    rng = np.random.default_rng(seed)
    free = np.argwhere(np.isfinite(field.cost))
    a, b = (tuple(int(n) for n in free[rng.integers(len(free))]) for _ in range(2))
    return a, b  # type: ignore[return-value]


def way_cost(field: CostField, cells: NDArray[np.int64]) -> float:
    costs = field.cost[cells[:, 0], cells[:, 1]].astype(float)
    steps = np.hypot(*np.diff(cells, axis=0).T)
    return float((0.5 * (costs[1:] + costs[:-1]) * steps).sum())


def dijkstra(field: CostField, start: tuple[int, int], goal: tuple[int, int]) -> float:
    """Cell by cell, by the textbook."""
    best = {start: 0.0}
    heap = [(0.0, start)]
    while heap:
        so_far, (i, j) = heapq.heappop(heap)
        if (i, j) == goal:
            return so_far
        if so_far > best[i, j]:
            continue
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                a, b = i + di, j + dj
                if not (0 <= a < field.frame.rows and 0 <= b < field.frame.columns) or not np.isfinite(
                    field.cost[a, b]
                ):
                    continue
                total = so_far + 0.5 * math.hypot(di, dj) * float(field.cost[i, j] + field.cost[a, b])
                if total < best.get((a, b), math.inf):
                    best[a, b] = total
                    heapq.heappush(heap, (total, (a, b)))
    return math.inf


@settings(max_examples=150)
@given(st.integers(0, 100_000), st.sampled_from([(0.0, 0.0), (-0.05, 0.0), (0.0, 0.05), (1.05, -7.05)]))
def test_a_way_is_found_exactly_where_the_free_cells_are_connected(seed: int, origin: tuple[float, float]) -> None:
    field = field_of(seed, origin)
    start, goal = ends(field, seed)
    _, parts = cv2.connectedComponents(np.isfinite(field.cost).astype(np.uint8), connectivity=8)
    way = cheapest_way(field, start, goal)
    assert (way is not None) == (parts[start] == parts[goal])
    if way is None:
        return
    assert tuple(way[0]) == start
    assert tuple(way[-1]) == goal
    assert np.isfinite(field.cost[way[:, 0], way[:, 1]]).all()
    assert (np.abs(np.diff(way, axis=0)).max(axis=1, initial=0) <= 1).all()
    assert (np.abs(np.diff(way, axis=0)).sum(axis=1) > 0).all()
    assert way_cost(field, way) >= math.dist(start, goal) - 1e-6


@pytest.mark.parametrize("seed", range(12))
def test_a_way_costs_little_more_than_the_textbook_finds_cell_by_cell(seed: int) -> None:
    field = field_of(seed)
    start, goal = ends(field, seed + 1000)
    way, least = cheapest_way(field, start, goal), dijkstra(field, start, goal)
    if way is None:
        assert least == math.inf
    else:
        assert way_cost(field, way) <= 1.06 * least + 6.0


@given(st.integers(0, 100_000), st.integers(0, 7), st.integers(0, 7))
def test_a_map_that_grows_keeps_its_ways(seed: int, down: int, left: int) -> None:
    # Nothing is known at its edges, as of a map that may grow
    cells = np.pad(random_cells(seed)[3:-3, 3:-3], 3, constant_values=-1)
    grown = grid_of(
        np.pad(cells, ((down, 3), (left, 2)), constant_values=-1), origin=(0.35 - 0.05 * left, -1.0 - 0.05 * down)
    )
    settings = CostSettings(unknown_cost=40.0)
    field = cost_field(grid_of(cells, origin=(0.35, -1.0)), SMALL, settings=settings)
    larger = cost_field(grown, SMALL, settings=settings)
    start, goal = ends(field, seed)
    way = cheapest_way(field, start, goal)
    other = cheapest_way(larger, (start[0] + down, start[1] + left), (goal[0] + down, goal[1] + left))
    if way is None or other is None:
        return
    # New obstacles raise the cost, but a path may lead around by it where it did not before.
    if ((other - [down, left] >= 0) & (other - [down, left] < cells.shape)).all():
        assert way_cost(larger, other) == pytest.approx(way_cost(field, way), rel=1e-5)
        assert np.array_equal(other - [down, left], way)


@given(st.integers(0, 100_000), st.integers(-500, 500), st.integers(-500, 500))
def test_ways_do_not_depend_on_where_the_map_lies(seed: int, right: int, up: int) -> None:
    field, moved = field_of(seed), field_of(seed, (0.1 * right, 0.1 * up))
    start, goal = ends(field, seed)
    way, other = cheapest_way(field, start, goal), cheapest_way(moved, start, goal)
    assert (way is None) == (other is None)
    if way is not None and other is not None:
        assert np.array_equal(way, other)


def test_from_or_to_a_lethal_cell_there_is_no_way() -> None:
    cells = np.zeros((30, 30), dtype=np.int8)
    cells[10, 10] = 100
    field = cost_field(grid_of(cells), SMALL)
    assert cheapest_way(field, (10, 10), (20, 20)) is None
    assert cheapest_way(field, (20, 20), (10, 10)) is None
    assert cheapest_way(field, (20, 20), (20, 20)) is not None
