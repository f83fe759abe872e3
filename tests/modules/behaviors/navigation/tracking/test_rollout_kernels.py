from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.tracking.rollout_kernels import can_stop, clearance_at, distance_at, driven
from tests.modules.behaviors.navigation.scenes import (
    FAST,
    HOLONOMIC,
    LIMITS,
    LONG,
    SQUARE,
    body_of,
    distance_to,
    field_of,
    wall,
)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-math.pi, math.pi))
def test_clearance_is_that_of_the_footprint_to_a_cell(seed: int, theta: float) -> None:
    obstacles = np.random.default_rng(seed).uniform(-1.5, 1.5, (30, 2))
    body, field = body_of(FAST, LONG), field_of(obstacles)
    clearance = clearance_at(field.distances, field.frame, body.outline, body.radii, 0.1, -0.2, theta)
    exact = distance_to(obstacles, Pose2(0.1, -0.2, theta), 0.254, 0.215)
    if exact < 0.25:
        assert max(clearance, 0) == pytest.approx(max(exact, 0), abs=0.045)
    else:
        assert clearance <= exact + 0.045, "further off it is a lower bound"
        assert clearance > 0.1


def test_distances_are_read_between_cells_and_held_beyond_the_edge() -> None:
    field = field_of(wall(0.0, -3.0, 0.0, 3.0))
    for x in (0.3, 0.31, 0.5, 1.234):
        assert distance_at(field.distances, field.frame, x, 0.2) == pytest.approx(x - 0.0125, abs=0.015)
    assert distance_at(field.distances, field.frame, 99.0, 0.0) == pytest.approx(3.0, abs=0.05)


@given(st.floats(-0.4, 0.4), st.floats(-1, 1), st.floats(-0.4, 0.4), st.floats(-1, 1), st.floats(0.01, 1))
def test_a_driven_body_obeys_its_accelerations(
    v: float, w: float, linear: float, angular: float, time_s: float
) -> None:
    limits = (-0.4, 0.4, 1.0, 0.4, 4.0, 0.4, 0.0)
    x, y, theta, v1, w1, u1 = driven((0.0, 0.0, 0.0, v, w, 0.0), linear, angular, 0.3, limits, time_s)
    assert u1 == 0.0
    assert abs(v1 - v) <= 0.4 * time_s + 1e-9
    assert abs(w1 - w) <= 4.0 * time_s + 1e-9
    assert math.hypot(x, y) <= 0.4 * time_s + 1e-9
    assert abs(theta) <= time_s + 1e-9


@pytest.mark.parametrize(("distance_m", "can"), [(0.25 + 0.2 + 0.08, True), (0.25 + 0.2 - 0.03, False)])
def test_what_cannot_be_stopped_before_is_known(distance_m: float, can: bool) -> None:
    # At 0.4 m/s and 0.4 m/s² it takes 0.2 m to stop, after the 0.04 m that it goes on within 0.1 s.
    field, body = field_of(wall(distance_m, -2, distance_m, 2)), body_of(LIMITS, SQUARE)
    scene = (field.distances, field.frame, body.outline, body.radii, body.limits)
    assert can_stop(*scene, (0.0, 0.0, 0.0, 0.4, 0.0, 0.0), (0.4, 0.0, 0.0), 0.1, 0.0) is can


def test_in_touch_it_may_go_away_but_no_nearer() -> None:
    field, body = field_of(wall(0.26, -2, 0.26, 2)), body_of(LIMITS, SQUARE)
    scene = (field.distances, field.frame, body.outline, body.radii, body.limits, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert can_stop(*scene, (-0.2, 0.0, 0.0), 0.1, 0.04)
    assert not can_stop(*scene, (0.2, 0.0, 0.0), 0.1, 0.04)


speeds = st.floats(-0.5, 0.5)


@given(st.tuples(speeds, speeds), st.tuples(speeds, speeds), st.floats(0.01, 0.3))
def test_a_holonomic_bodys_velocity_changes_as_a_vector(
    before: tuple[float, float], target: tuple[float, float], time_s: float
) -> None:
    limits = (0.0, 0.4, 1.0, 0.4, 4.0, 0.4, 0.3)
    state = (0.0, 0.0, 0.0, before[0], 0.0, before[1])
    x, y, theta, v1, w1, u1 = driven(state, target[0], 0.0, target[1], limits, time_s)
    changed, whole = complex(v1 - before[0], u1 - before[1]), complex(target[0] - before[0], target[1] - before[1])
    assert abs(changed) == pytest.approx(min(abs(whole), 0.4 * time_s), abs=1e-9)
    assert (changed * whole.conjugate()).imag == pytest.approx(0.0, abs=1e-9)
    assert (x, y) == pytest.approx(((before[0] + v1) / 2 * time_s, (before[1] + u1) / 2 * time_s))
    assert theta == w1 == 0.0


def test_what_cannot_be_stopped_before_is_known_to_the_side_too() -> None:
    body = body_of(HOLONOMIC, SQUARE)
    for distance_m, can in ((0.25 + 0.13 + 0.08, True), (0.25 + 0.13 - 0.03, False)):
        field = field_of(wall(-2, distance_m, 2, distance_m))
        scene = (field.distances, field.frame, body.outline, body.radii, body.limits)
        assert can_stop(*scene, (0.0, 0.0, 0.0, 0.0, 0.0, 0.3), (0.0, 0.0, 0.3), 0.1, 0.0) is can
