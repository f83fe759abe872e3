"""The point ahead, on a path and on an arc."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.behaviors.gaze.look_ahead import ahead_on_arc, ahead_on_path

PATH = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])


def test_a_path_is_followed_around_its_corner_from_the_point_nearest_to_the_robot() -> None:
    assert ahead_on_path(PATH, Pose2(1.5, 0.1, 0.0), 1.0) == pytest.approx([0.5, 0.4])
    assert ahead_on_path(PATH, Pose2(1.5, 0.0, math.pi / 2), 1.0) == pytest.approx([0.5, -0.5])


def test_beyond_its_end_a_path_gives_its_end_and_none_gives_none() -> None:
    assert ahead_on_path(PATH, Pose2(), 100.0) == pytest.approx([2.0, 2.0])
    assert ahead_on_path(PATH[:1] + 1.0, Pose2(), 5.0) == pytest.approx([1.0, 1.0])
    assert ahead_on_path(np.empty((0, 2)), Pose2(), 1.0) is None


@given(st.floats(-0.4, 0.4).filter(lambda v: abs(v) > 0.05), st.floats(-1, 1), st.floats(0.5, 5))
def test_the_arc_is_that_of_the_twist(linear: float, angular: float, ahead_s: float) -> None:
    pose, steps = Pose2(), 2000
    for _ in range(steps):
        dt = ahead_s / steps
        pose = pose @ Pose2(linear * dt, 0.0, angular * dt)
    assert ahead_on_arc(linear, angular, ahead_s, 0.0) == pytest.approx([pose.x, pose.y], abs=0.01)


def test_a_slow_robot_looks_the_least_distance_ahead_and_a_turning_one_into_its_turn() -> None:
    assert ahead_on_arc(0.1, 0.0, 1.0, 1.0) == pytest.approx([1.0, 0.0])
    assert ahead_on_arc(0.0, 0.5, 1.0, 1.0) == pytest.approx([math.cos(0.5), math.sin(0.5)])
