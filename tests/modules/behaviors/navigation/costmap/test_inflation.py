from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.behaviors.navigation.costmap.inflation import (
    AT_KEEP_OUT,
    AT_OCCUPIED,
    AT_TEMPORARY,
    OCCUPIED,
    CostField,
    CostSettings,
    cost_field,
    with_obstacles,
)
from tests.modules.behaviors.navigation.maps import OBLONG, ROUND, box, grid_of, office, random_cells, zone

ZONES = (zone("keep_out", box(1.0, 1.0, 2.0, 1.5)), zone("slow", box(0.5, 2.0, 3.0, 3.0), 0.25))


def same(a: CostField, b: CostField) -> bool:
    # OpenCV's distances differ in the last bit by where in the array they are.
    close = np.allclose(a.clearance, b.clearance, 1e-6) and np.allclose(a.cost, b.cost, 1e-5)
    return close and np.array_equal(a.layers, b.layers)


def test_what_a_metre_costs_by_its_distance_to_a_wall() -> None:
    cells = np.zeros((100, 100), dtype=np.int8)
    cells[:, 0] = 100
    field = cost_field(grid_of(cells), OBLONG)
    row = field.cost[50]
    distance = 0.05 * np.arange(100)
    assert np.isinf(row[distance < OBLONG.inscribed_m]).all()
    near = (distance >= OBLONG.inscribed_m) & (distance < field.reach_m)
    assert (np.diff(row[near]) < 0).all()
    assert row[near][0] < 1.0 + CostSettings().closeness
    assert (row[distance >= field.reach_m] == 1.0).all()


def test_unknown_space_by_policy() -> None:
    cells = np.zeros((40, 40), dtype=np.int8)
    cells[:, 20:] = -1
    for unknown, cost in (("free", 1.0), ("costly", 11.0), ("blocked", math.inf)):
        field = cost_field(grid_of(cells), ROUND, settings=CostSettings(unknown=unknown))
        assert (field.cost[:, :20] == 1.0).all()
        assert (field.cost[:, 20:] == cost).all()


def test_single_cells_count_as_what_is_around_them() -> None:
    cells = np.zeros((40, 80), dtype=np.int8)
    cells[:, 40:] = -1
    cells[10:30:5, 10] = -1
    cells[20, 60:80] = 0
    field = cost_field(grid_of(cells), ROUND, settings=CostSettings(unknown="blocked"))
    assert (field.cost[:, :40] == 1.0).all()
    assert np.isinf(field.cost[:, 40:]).all()


def test_zones_cost_and_keep_out() -> None:
    field = cost_field(grid_of(np.zeros((80, 80), dtype=np.int8)), ROUND, ZONES)
    inside, beside = field.frame.cell(1.5, 1.25), field.frame.cell(1.5, 1.7)
    assert inside is not None
    assert beside is not None
    assert np.isinf(field.cost[inside])
    assert np.isinf(field.cost[beside])
    assert field.layers[beside] & AT_KEEP_OUT
    assert not field.layers[beside] & AT_OCCUPIED
    slow = field.frame.cell(0.6, 2.9)
    assert slow is not None
    assert field.cost[slow] == 4.0


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.booleans(), st.integers(1, 40))
def test_made_again_only_where_the_map_changed_is_the_same_as_made_again(seed: int, zoned: bool, changes: int) -> None:
    rng = np.random.default_rng(seed)
    zones = ZONES if zoned else ()
    cells = random_cells(seed, 260, 300)
    before = cost_field(grid_of(cells), OBLONG, zones)
    after_cells = cells.copy()
    # All in one place, as when a loop is not closed, or anywhere
    width = 10 if rng.random() < 0.5 else 250
    for _ in range(changes):
        after_cells[tuple(rng.integers(0, width, 2))] = rng.choice([-1, 0, 100])
    kept: list[np.ndarray] = [before.layers.copy(), before.clearance.copy(), before.cost.copy()]
    quick = cost_field(grid_of(after_cells), OBLONG, zones, previous=before)
    assert same(quick, cost_field(grid_of(after_cells), OBLONG, zones))
    now: list[np.ndarray] = [before.layers, before.clearance, before.cost]
    assert all(np.array_equal(was, array) for was, array in zip(kept, now, strict=True)), (
        "what others may still use is left as it is"
    )


def test_nothing_changed_nothing_made() -> None:
    field = cost_field(office(), ROUND, ZONES)
    assert cost_field(office(), ROUND, ZONES, previous=field) is field


def test_a_map_that_grew_and_other_zones_are_made_from_the_beginning() -> None:
    grid = office()
    field = cost_field(grid, ROUND)
    larger = grid_of(np.pad(grid.cells, 10), origin=(-0.5, -0.5))
    assert same(cost_field(larger, ROUND, previous=field), cost_field(larger, ROUND))
    assert same(cost_field(grid, ROUND, ZONES, previous=field), cost_field(grid, ROUND, ZONES))


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 30))
def test_temporary_obstacles_cost_as_those_of_the_map(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    cells = random_cells(seed, 200, 220)
    places = rng.integers(0, 200, (count, 2))
    points = (places[:, ::-1].astype(np.float64) + 0.5) * 0.05
    cells = np.where(cells < 0, np.int8(0), cells)
    known = cost_field(grid_of(cells), OBLONG, ZONES, CostSettings(unknown="free"))
    live = with_obstacles(known, points)
    marked = cells.copy()
    marked[places[:, 0], places[:, 1]] = 100
    solid = cost_field(grid_of(marked), OBLONG, ZONES, CostSettings(unknown="free"))
    assert np.allclose(live.cost, solid.cost, 1e-5)
    assert np.allclose(live.clearance, solid.clearance, 1e-6)
    assert live.known is known
    new = ~np.isfinite(live.cost) & np.isfinite(known.cost)
    assert (live.layers[new] & AT_TEMPORARY != 0).all()
    assert not (live.layers[new] & OCCUPIED).any()


def test_other_temporary_obstacles_replace_those_before_and_off_the_map_there_are_none() -> None:
    field = cost_field(office(), ROUND)
    once = with_obstacles(field, np.array([[3.0, 4.5]]))
    then = with_obstacles(once, np.array([[8.0, 4.5]]))
    assert same(then, with_obstacles(field, np.array([[8.0, 4.5]])))
    assert with_obstacles(once, np.array([[-50.0, 4.5]])) is field
