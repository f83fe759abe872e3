"""Sweeps made ready: motion taken out, normals towards the laser, what was not measured left out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.scans import BeamGeometry, prepared
from tests.modules.perception.slam.rooms import half_circle, room, seen

LASER = BeamGeometry(half_circle(541).angles, 0.05, 30.0, Pose2(0.2, 0.05, 0.1))


def after(twist: tuple[float, float, float], elapsed: float) -> Pose2:
    """Where a body with ``twist`` is, by many small steps."""
    pose = Pose2()
    for _ in range(200):
        pose = pose @ Pose2(twist[0] * elapsed / 200, twist[2] * elapsed / 200, twist[1] * elapsed / 200)
    return pose


@given(speed=st.floats(-1.5, 1.5), turning=st.floats(-2.0, 2.0), aside=st.floats(-1.0, 1.0))
@settings(max_examples=10, deadline=None)
def test_a_moving_body_sees_the_room_as_one_that_stands(speed: float, turning: float, aside: float) -> None:
    start, sweep_s = Pose2(0, 1, 0.5), 0.1
    count = len(LASER.angles)
    poses = [start @ after((speed, turning, aside), sweep_s * k / (count - 1)) for k in range(0, count, 20)]
    some = BeamGeometry(LASER.angles[::20], 0.05, 30.0, LASER.X_BL)
    moving = prepared(seen(room(), some, poses), some, (speed, turning, aside), sweep_s, 25.0, 0.0)
    # Every end lies on a wall, seen from where the sweep began.
    on_walls = [start @ Pose2(float(x), float(y)) for x, y in moving.ends]
    assert max(_to_walls(p.x, p.y) for p in on_walls) < 2e-3


def test_without_the_twist_they_do_not() -> None:
    """What the test above would see if nothing were taken out."""
    some = BeamGeometry(LASER.angles[::20], 0.05, 30.0, LASER.X_BL)
    start = Pose2(0, 1, 0.5)
    poses = [start @ after((1.0, 1.5, 0.0), 0.1 * k / (len(some.angles) - 1)) for k in range(len(some.angles))]
    still = prepared(seen(room(), some, poses), some, (0.0, 0.0, 0.0), 0.0, 25.0, 0.0)
    assert max(_to_walls((p := start @ Pose2(float(x), float(y))).x, p.y) for x, y in still.ends) > 0.05


def test_normals_are_unit_and_point_towards_the_laser() -> None:
    scan = prepared(seen(room(), LASER, Pose2(0, 1, 0.5)), LASER, (0.0, 0.0, 0.0), 0.0, 25.0, 0.03)
    normals, to_laser = scan.points[:, 2:], scan.origin - scan.points[:, :2]
    known = np.hypot(*normals.T) > 0
    assert known.mean() > 0.9
    np.testing.assert_allclose(np.hypot(*normals[known].T), 1.0, atol=1e-5)
    assert ((normals * to_laser).sum(axis=1)[known] >= 0).all()
    assert np.hypot(*np.diff(scan.points[:, :2], axis=0).T).min() >= 0.03 - 1e-6


def test_what_was_not_measured_is_no_point() -> None:
    beams = half_circle(7)
    scan = prepared(np.array([1.0, 0.01, np.nan, np.inf, 30.0, 26.0, 2.0]), beams, (0.0, 0.0, 0.0), 0.0, 25.0, 0.0)
    np.testing.assert_allclose(np.hypot(*scan.points[:, :2].T), [1.0, 2.0], atol=1e-5)
    np.testing.assert_allclose(np.hypot(*scan.ends.T), [1.0, 30.0, 30.0, 26.0, 2.0], atol=1e-4)
    assert scan.hits.tolist() == [True, False, False, True, True]


def test_a_laser_that_names_no_greatest_range_has_ends_all_the_same() -> None:
    beams = BeamGeometry(np.linspace(-1.0, 1.0, 5), 0.05, math.inf)
    scan = prepared(np.array([1.0, math.inf, math.nan, 2.0, 3.0]), beams, (0.0, 0.0, 0.0), 0.0, 25.0, 0.0)
    assert np.isfinite(scan.ends).all()
    assert scan.hits.tolist() == [True, False, True, True]


def test_other_ranges_than_beams_are_refused() -> None:
    with pytest.raises(ValueError, match="3 ranges of 7 beams"):
        prepared(np.ones(3), half_circle(7), (0.0, 0.0, 0.0), 0.0, 25.0, 0.0)


def _to_walls(x: float, y: float) -> float:
    walls = room()
    start, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    to = np.array([x, y]) - start
    share = np.clip((to * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(to - share[:, None] * along).T).min())


def test_a_full_turn_in_a_sweep_stays_finite() -> None:
    scan = prepared(np.ones(7), half_circle(7), (1.0, 2 * math.pi, 0.0), 1.0, 25.0, 0.0)
    assert np.isfinite(scan.ends).all()
