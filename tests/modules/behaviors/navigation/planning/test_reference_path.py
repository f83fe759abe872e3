from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.planning.reference_path import SPACING_M, ReferencePath, resampled

CORNER = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])


def track(points: np.ndarray = CORNER, **more: Any) -> ReferencePath:
    return ReferencePath(points, speed_mps=1.0, braking_mps2=0.5, **more)


@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=12))
def test_a_polyline_is_resampled_evenly_from_end_to_end(points: list[tuple[float, float]]) -> None:
    given_points = np.array(points)
    even = resampled(given_points, SPACING_M)
    assert len(even) >= 2
    assert even[0] == pytest.approx(given_points[0])
    assert even[-1] == pytest.approx(given_points[-1], abs=1e-6)
    assert np.linalg.norm(np.diff(even, axis=0), axis=1).max() <= SPACING_M * 1.6


def test_what_remains_counts_along_the_path() -> None:
    followed = track()
    assert followed.length_m == pytest.approx(4.0, abs=0.02)
    assert followed.come_to(Pose2(0.5, 0.1, 0.0)) == pytest.approx((3.5, 0.1), abs=0.03)
    assert followed.come_to(Pose2(1.9, 0.0, 0.0))[0] == pytest.approx(2.1, abs=0.03)


def test_a_path_that_comes_by_twice_is_followed_in_order() -> None:
    there_and_back = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.3], [0.0, 0.3]])
    followed = track(there_and_back)
    for x in np.arange(0.0, 2.0, 0.1):
        remaining, _ = followed.come_to(Pose2(float(x), 0.14, 0.0))
        assert remaining > 4.0


def test_the_way_ahead_is_in_the_frame_asked_for_and_as_long() -> None:
    followed = track()
    followed.come_to(Pose2(1.0, 0.0, 0.0))
    X_FM = Pose2(5.0, 1.0, math.pi / 2)
    way = followed.ahead(X_FM, 0.5)
    assert way.points[0, :3] == pytest.approx([5.0, 2.0, math.pi / 2], abs=0.03)
    assert way.points[-1, 3] == pytest.approx(0.5, abs=0.05)


def test_speed_falls_in_time_for_a_zone_and_for_the_end() -> None:
    slow_end = track(speed_at=lambda points: np.where(points[:, 1] > 1.0, 0.2, 1.0))
    slow_end.come_to(Pose2(0.0, 0.0, 0.0))
    way = slow_end.ahead(Pose2(), 5.0)
    speeds, lengths = way.points[:, 4], way.points[:, 3]
    assert speeds[0] == pytest.approx(1.0)
    assert speeds[lengths > 3.05].max() <= 0.2 + 1e-6
    assert speeds[-1] < 0.05
    falling = -np.diff(speeds**2) / np.diff(lengths)
    assert falling[lengths[1:] < 3.0].max() <= 2 * 0.5 + 1e-6, "no harder than it can brake"
    assert slow_end.ahead(Pose2(), 5.0, stop=False).points[-1, 4] == pytest.approx(0.2)


def test_a_path_of_one_point_is_a_way() -> None:
    here = track(np.array([[1.0, 1.0]]))
    assert here.come_to(Pose2(1.0, 1.2, 0.0)) == pytest.approx((0.0, 0.2))
    assert len(here.ahead(Pose2(), 2.0).points) == 2
