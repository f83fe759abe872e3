"""The point budget: what a viewer is sent follows the lag that was measured of it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.view.budget import (
    FEWEST_POINTS,
    FIRST_POINTS,
    LONGEST_PERIOD_S,
    MOST_POINTS,
    SHORTEST_PERIOD_S,
    TARGET_LAG_S,
    PointBudget,
    divided,
    measured,
    silent,
)
from app.console.view.voxel_nodes import share_of
from app.console.view.voxels import MOST_VOXELS


def test_a_fast_viewer_is_given_everything_in_time() -> None:
    budget = PointBudget()
    steps = 0
    while budget.points < MOST_POINTS:
        before = budget.points
        budget = measured(budget, 0.02)
        assert budget.points <= 1.11 * before, "it rises smoothly"
        steps += 1
    # 4 measurements a second.
    assert steps <= 40


@pytest.mark.parametrize("cloud", [0, 4_800, 19_200, 76_800])
def test_a_view_that_draws_at_ease_is_dense_once_the_map_is_full(cloud: int) -> None:
    newest, remembered = divided(MOST_POINTS, cloud)
    assert newest + remembered == MOST_POINTS
    assert newest + share_of(MOST_VOXELS, remembered) * MOST_VOXELS >= 75_000


@given(st.integers(FEWEST_POINTS, MOST_POINTS), st.integers(0, 307_200))
def test_the_newest_cloud_gets_half_at_most_and_no_more_than_it_has(points: int, cloud: int) -> None:
    newest, remembered = divided(points, cloud)
    assert newest + remembered == points
    assert newest == cloud or newest == points // 2
    assert newest <= min(cloud, remembered)


def test_a_silent_viewer_is_sent_the_least() -> None:
    budget = PointBudget(points=MOST_POINTS)
    for _ in range(12):
        budget = silent(budget)
    assert budget.points == FEWEST_POINTS


def test_it_settles_where_the_lag_is_under_the_target() -> None:
    """A viewer whose lag is 20 ms and 20 µs a point: 9,000 points are 200 ms."""
    budget = PointBudget(points=60_000)
    lags = []
    for _ in range(200):
        lag = 0.02 + 20e-6 * budget.points
        lags.append(lag)
        budget = measured(budget, lag)
    assert max(lags[12:]) < 1.1 * TARGET_LAG_S
    assert sum(lags[50:]) / 150 < TARGET_LAG_S
    assert 5_000 < budget.points < 9_500


def test_a_page_that_draws_slowly_is_sent_less_and_less_often() -> None:
    """Two frames that take 20 ms and 20 µs a point, over a link without any lag."""
    budget = PointBudget(points=40_000)
    assert budget.period_s == SHORTEST_PERIOD_S
    for _ in range(100):
        budget = measured(budget, 0.03, 0.02 + 20e-6 * budget.points)
    assert 2_000 < budget.points < 4_400
    assert 3 * 0.05 < budget.period_s <= 3 * 0.12
    for _ in range(100):
        budget = silent(budget)
    assert budget.period_s == LONGEST_PERIOD_S


def test_one_late_answer_is_no_trend() -> None:
    budget = PointBudget()
    for _ in range(20):
        budget = measured(budget, 0.03)
    before = budget.points
    budget = measured(budget, 0.5)
    assert budget.points >= before


@given(st.lists(st.one_of(st.none(), st.floats(0, 10))))
def test_it_stays_within_its_bounds(lags: list[float | None]) -> None:
    budget = PointBudget()
    assert budget.points == FIRST_POINTS
    for lag in lags:
        budget = silent(budget) if lag is None else measured(budget, lag)
        assert FEWEST_POINTS <= budget.points <= MOST_POINTS
