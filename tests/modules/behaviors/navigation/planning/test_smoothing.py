from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.behaviors.navigation.costmap.inflation import CostSettings, cost_field
from app.modules.behaviors.navigation.planning.smoothing import length_of, smooth, with_headings
from tests.modules.behaviors.navigation.maps import (
    ROUND,
    cheapest_way,
    cost_along,
    grid_of,
    lethal_along,
    office,
    random_cells,
)


def middles(cells: np.ndarray, resolution_m: float = 0.05) -> np.ndarray:
    return (cells[:, ::-1] + 0.5) * resolution_m


@settings(max_examples=40)
@given(st.integers(0, 100_000))
def test_a_smooth_way_stays_free_and_costs_no_more_and_no_less_than_straight(seed: int) -> None:
    # Rounding may cut corners of expensive cells that are not lethal.
    field = cost_field(grid_of(random_cells(seed, 120, 140)), ROUND, settings=CostSettings(unknown="free"))
    free = np.argwhere(np.isfinite(field.cost))
    rng = np.random.default_rng(seed)
    if len(free) < 2:
        return
    start, goal = (tuple(free[rng.integers(len(free))].tolist()) for _ in range(2))
    cells = cheapest_way(field, start, goal)
    if cells is None:
        return
    before = middles(cells)
    way = smooth(field, before, 0.05)
    assert np.allclose(way[[0, -1]], before[[0, -1]])
    assert lethal_along(field, way) == 0
    assert np.linalg.norm(before[0] - before[-1]) - 1e-9 <= length_of(way)
    assert cost_along(field, way) <= 1.25 * cost_along(field, before) + 0.2
    if len(way) > 1:
        assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() <= 0.0501


def test_in_the_open_the_way_is_straight() -> None:
    field = cost_field(grid_of(np.zeros((200, 300), dtype=np.int8)), ROUND)
    cells = cheapest_way(field, (10, 10), (150, 290))
    assert cells is not None
    way = smooth(field, middles(cells), 0.05)
    assert length_of(way) == pytest.approx(0.05 * math.dist((10, 10), (150, 290)), rel=1e-4)


def test_corners_are_rounded() -> None:
    field = cost_field(office(), ROUND)
    cells = cheapest_way(field, (12, 12), (145, 12))
    assert cells is not None
    poses = with_headings(smooth(field, middles(cells), 0.05), 0.0, math.nan)
    turns = np.abs((np.diff(poses[:, 2]) + np.pi) % (2 * np.pi) - np.pi)
    assert turns.max() < 0.35, "at no pose does it turn by more than 20 degrees"


def test_headings_lead_along_the_way() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert np.allclose(with_headings(points, 0.0, math.nan)[:, 2], [0.0, math.pi / 4, math.pi / 2])
    assert np.allclose(with_headings(points, 0.0, 3.0)[:, 2], [0.0, math.pi / 4, 3.0])
    assert with_headings(points[:1], 0.7, math.nan)[0, 2] == 0.7
