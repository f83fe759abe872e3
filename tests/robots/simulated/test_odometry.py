"""Wheel odometry: exact for perfect wheels, drifting as configured for real ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.robots.simulated.odometry import EncoderOdometry, HolonomicOdometry, TrueBase, draw_true_base
from app.robots.stream_config import BaseConfig

IDEAL = BaseConfig(radius_error=0, track_error=0, slip=0, encoder_ticks=10_000_000)


def roll(
    config: BaseConfig, true: TrueBase, linear: float, angular: float, seconds: float, seed: int
) -> EncoderOdometry:
    """Odometry of a base that truly moves at this twist."""
    odometry = EncoderOdometry(config, np.random.default_rng(seed))
    dt = 0.01
    for i in range(round(seconds / dt) + 1):
        left = (linear - angular * true.track_m / 2) / true.left_radius_m * i * dt
        right = (linear + angular * true.track_m / 2) / true.right_radius_m * i * dt
        odometry.update(left, right, dt)
    return odometry


@given(st.floats(-0.4, 0.4), st.floats(-1, 1))
def test_perfect_wheels_give_the_true_arc(linear: float, angular: float) -> None:
    odometry = roll(IDEAL, TrueBase(0.10, 0.10, 0.44), linear, angular, 3.0, 0)
    heading = 3.0 * angular
    if abs(angular) > 1e-6:
        x, y = linear / angular * math.sin(heading), linear / angular * (1 - math.cos(heading))
    else:
        x, y = 3.0 * linear, 0.0
    assert (odometry.X_OB.x, odometry.X_OB.y) == pytest.approx((x, y), abs=1e-4)
    assert math.remainder(odometry.X_OB.theta - heading, 2 * math.pi) == pytest.approx(0, abs=1e-4)
    assert odometry.linear_mps == pytest.approx(linear, abs=1e-3)
    assert odometry.angular_radps == pytest.approx(angular, abs=1e-3)


def test_it_starts_at_zero_whatever_the_wheels_read() -> None:
    odometry = EncoderOdometry(BaseConfig(), np.random.default_rng(1))
    odometry.update(12.3, -4.5, 0.01)
    assert (odometry.X_OB.x, odometry.X_OB.y, odometry.X_OB.theta) == (0, 0, 0)


def test_real_wheels_drift_but_not_by_more_than_a_few_percent() -> None:
    errors = []
    for seed in range(20):
        true = draw_true_base(BaseConfig(), np.random.default_rng(100 + seed))
        odometry = roll(BaseConfig(), true, 0.4, 0.0, 25.0, seed)
        errors.append(math.hypot(odometry.X_OB.x - 10.0, odometry.X_OB.y) / 10.0)
    assert np.median(errors) > 0.001
    assert max(errors) < 0.15  # ten metres without looking: wheels that differ by 0.4 % bend the path by 0.5 m
    assert np.median(errors) < 0.06


def test_slip_alone_grows_with_distance() -> None:
    config = BaseConfig(radius_error=0, track_error=0)
    true = TrueBase(0.10, 0.10, 0.44)

    def spread(seconds: float) -> float:
        return float(np.std([roll(config, true, 0.4, 0.0, seconds, s).X_OB.theta for s in range(30)]))

    assert 0 < spread(2.5) < spread(25.0) < 0.2


def test_standing_still_stays_exactly_still() -> None:
    odometry = roll(BaseConfig(), TrueBase(0.10, 0.10, 0.44), 0.0, 0.0, 5.0, 3)
    assert (odometry.X_OB.x, odometry.X_OB.theta, odometry.linear_mps) == (0, 0, 0)


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-1, 1))
def test_a_perfect_holonomic_base_measures_its_path_and_its_twist(forward: float, left: float, turn: float) -> None:
    odometry = HolonomicOdometry(IDEAL, np.random.default_rng(0))
    pose, dt = Pose2(3.0, -2.0, 0.7), 0.01
    start = pose
    step = Pose2(0, 0, turn * dt / 2) @ Pose2(forward * dt, left * dt, turn * dt / 2)
    for _ in range(300):
        odometry.update(pose, dt)
        pose = pose @ step
    odometry.update(pose, dt)
    moved = start.inverse() @ pose
    assert (odometry.X_OB.x, odometry.X_OB.y) == pytest.approx((moved.x, moved.y), abs=1e-6)
    assert math.remainder(odometry.X_OB.theta - moved.theta, 2 * math.pi) == pytest.approx(0, abs=1e-6)
    twist = (odometry.linear_mps, odometry.lateral_mps, odometry.angular_radps)
    assert twist == pytest.approx((forward, left, turn), abs=1e-6)


def test_a_real_holonomic_base_drifts_as_configured() -> None:
    config = BaseConfig(radius_error=0.01, track_error=0, slip=0)
    lengths = []
    for seed in range(20):
        odometry = HolonomicOdometry(config, np.random.default_rng(seed))
        for i in range(201):
            odometry.update(Pose2(0.0, 0.01 * i), 0.01)
        lengths.append(math.hypot(odometry.X_OB.x, odometry.X_OB.y))
    assert 0 < max(abs(length - 2.0) for length in lengths) <= 0.04
