"""The far end of a laser's readings: found where they pile up, and no wall taken for it."""

from __future__ import annotations

import numpy as np
import pytest

from app.logs.importers.range_limit import FarEnd


def readings(scans: int = 400, rays: int = 180, seed: int = 0) -> np.ndarray:
    """Walls at ever other distances, the more the nearer."""
    rng = np.random.default_rng(seed)
    return np.minimum(rng.exponential(5.0, (scans, rays)), 49.0)


def limit_of(ranges: np.ndarray) -> float | None:
    end = FarEnd()
    for row in ranges:
        end.add(row)
    return end.limit()


def with_share(ranges: np.ndarray, share: float, low: float, high: float) -> np.ndarray:
    rng = np.random.default_rng(1)
    chosen = rng.random(ranges.shape) < share
    return np.where(chosen, rng.uniform(low, high, ranges.shape), ranges)


@pytest.mark.parametrize(("low", "high"), [(50.5, 51.2), (29.9, 29.95), (31.99, 31.99)])
def test_a_pile_at_the_far_end_is_the_word_for_nothing(low: float, high: float) -> None:
    ranges = np.minimum(readings(), low - 1.0)
    ranges[ranges > 0.8 * low] = 3.0
    limit = limit_of(with_share(ranges, 0.0127, low, high))
    assert limit is not None
    assert low - 0.1 <= limit <= low


def test_nothing_is_found_where_nothing_piles_up() -> None:
    assert limit_of(readings() * 0.8) is None
    assert limit_of(np.full((3, 180), np.nan)) is None
    assert limit_of(np.full((3, 180), 81.83)) is None


def test_a_far_wall_seen_by_a_robot_at_rest_is_no_limit() -> None:
    ranges = np.minimum(readings(), 18.0)
    ranges[:, 80:100] = 30.0 + np.random.default_rng(2).normal(0.0, 0.02, (len(ranges), 20))
    assert limit_of(ranges) is None


def test_what_has_much_beyond_it_is_no_limit() -> None:
    ranges = with_share(np.minimum(readings(), 20.0), 0.02, 30.0, 30.3)
    assert limit_of(ranges) is not None
    assert limit_of(with_share(ranges, 0.002, 35.0, 60.0)) is None
