"""The figures by which trajectories are compared."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.modules.perception.slam.relations import between, composed, filled_in, relation_errors, trajectory_error


def poses(count: int = 50, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.column_stack((rng.uniform(-10, 10, (count, 2)), rng.uniform(-3.1, 3.1, count)))


def test_golden_relation_errors() -> None:
    first = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, math.pi / 2], [0.0, 0.0, 0.0]])
    second = np.array([[1.0, 0.0, 0.1], [1.0, 3.0, math.pi / 2], [0.0, 2.0, 0.0]])
    measured = np.array([[0.97, 0.04, 0.1], [1.0, 0.0, math.radians(-6.0)], [0.0, 1.0, 0.0]])
    errors = relation_errors(first, second, measured)
    assert errors.relations == 3
    assert errors.mean_m == pytest.approx((0.05 + 0.0 + 1.0) / 3)
    assert errors.sd_m == pytest.approx(np.std([0.05, 0.0, 1.0]))
    assert errors.max_m == pytest.approx(1.0)
    assert errors.mean_deg == pytest.approx(2.0)
    assert errors.gross == 2  # one by its angle, one by its place


def test_what_is_measured_is_composed_again() -> None:
    first, second = poses(seed=1), poses(seed=2)
    np.testing.assert_allclose(composed(first, between(first, second)), second, atol=1e-9)


def test_a_trajectory_elsewhere_is_no_error_and_a_bent_one_is() -> None:
    path = poses()
    moved = composed(np.broadcast_to([4.0, -2.0, 1.1], path.shape), path)
    assert trajectory_error(moved, path)[0] < 1e-9
    bent = path.copy()
    bent[7, 0] += 1.0
    mean, rmse, most = trajectory_error(bent, path)
    assert rmse == pytest.approx(1 / math.sqrt(50), rel=0.05)
    assert most == pytest.approx(1.0, abs=0.1)
    assert 1 / 50 <= mean < rmse


def test_between_scans_odometry_leads_from_both_sides() -> None:
    odometry = np.column_stack((np.arange(9.0), np.zeros(9), np.zeros(9)))
    rows = np.array([2, 6])
    found = np.array([[2.0, 0.0, 0.0], [6.0, 1.0, 0.0]])  # odometry missed a metre to the left on the way
    filled = filled_in(rows, found, odometry)
    np.testing.assert_allclose(filled[:, 0], np.arange(9.0))
    np.testing.assert_allclose(filled[:, 1], [0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1])
