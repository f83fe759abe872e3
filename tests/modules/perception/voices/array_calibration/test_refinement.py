"""Positions by least squares: exact where the sound is, robust, and plain about what it cannot know."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.calibration import geometry
from app.modules.perception.voices.array_calibration.refinement import refine
from app.modules.perception.voices.array_calibration.structure import aligned
from app.modules.perception.voices.steering_vectors import paths
from tests.modules.perception.voices.array_calibration.clap_sounds import CORNERS, CROSS, around, ways


def error_m(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """RMS distance of ``found`` from ``true``, both laid over one another."""
    return float(np.sqrt(((aligned(found, true) - true) ** 2).sum(axis=1).mean()))


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000))
def test_positions_in_space_are_found(seed: int) -> None:
    true = CORNERS + np.random.default_rng(seed).normal(0, 0.008, CORNERS.shape)
    fit = refine(ways(around(14, seed), true), geometry(CORNERS, 0.0))
    assert error_m(fit.positions, true) < 0.0006 < error_m(CORNERS, true)
    assert np.abs(fit.residuals).max() < 5e-4
    assert fit.undetermined == 0
    assert fit.deviations.max() < 0.003
    np.testing.assert_allclose(aligned(fit.positions, CORNERS), fit.positions, atol=1e-9)
    sources = around(14, seed)
    toward = sources / np.linalg.norm(sources, axis=1, keepdims=True)
    assert (fit.directions * toward).sum(axis=1).min() > np.cos(0.15)


def test_wrong_arrival_times_are_not_believed() -> None:
    rng = np.random.default_rng(1)
    true = CORNERS + rng.normal(0, 0.008, CORNERS.shape)
    heard = ways(around(16, 1), true)
    heard[3, 2] += 0.15
    heard[7, 5] -= 0.08
    heard[12] += rng.uniform(-0.1, 0.1, 8)
    fit = refine(heard, geometry(CORNERS, 0.0))
    assert error_m(fit.positions, true) < 0.0015
    assert max(fit.weights[3, 2], fit.weights[7, 5]) < 0.05
    # Some of what is all wrong fits a direction by chance.
    assert fit.weights[12].mean() < 0.6
    assert np.delete(fit.weights, [3, 7, 12], axis=0).min() > 0.5


def test_a_plane_keeps_to_itself_and_its_size() -> None:
    true = CROSS + np.random.default_rng(2).normal(0, 0.002, CROSS.shape) * (1, 1, 0)
    fit = refine(ways(around(16, 2, level=True), true), geometry(CROSS, 0.0))
    assert error_m(fit.positions, true) < 0.5 * error_m(CROSS, true)
    assert np.abs(fit.positions[:, 2]).max() < 1e-4
    assert fit.unevenness < 0.02
    assert refine(ways(around(16, 2), true), geometry(CROSS, 0.0)).unevenness > 0.03
    larger = refine(ways(around(16, 2, level=True), 1.3 * CROSS), geometry(CROSS, 0.0))
    assert np.linalg.norm(larger.positions) / np.linalg.norm(CROSS) == pytest.approx(1.3, abs=0.04)


def test_a_line_is_measured_along_itself() -> None:
    line = np.array([[x, 0.0, 0.0] for x in (-0.12, -0.03, 0.05, 0.1)])
    true = line + np.array([[0.004, 0, 0], [-0.006, 0, 0], [0.0, 0, 0], [0.002, 0, 0]])
    fit = refine(ways(around(16, 3), true), geometry(line, 0.0))
    assert error_m(fit.positions, true) < 0.3 * error_m(line, true)
    assert np.abs(fit.positions[:, 1:]).max() < 1e-3


def test_a_body_between_them_is_gone_round() -> None:
    rng = np.random.default_rng(4)
    true = CORNERS + rng.normal(0, 0.004, CORNERS.shape)
    true -= true.mean(axis=0)
    long, along = paths(true, around(24, 4), 0.16)
    heard = long + 0.05 * along
    fit = refine(heard - heard.mean(axis=1, keepdims=True), geometry(CORNERS, 0.16))
    assert error_m(fit.positions, true) < 0.0015
    in_air = refine(heard - heard.mean(axis=1, keepdims=True), geometry(CORNERS, 0.0))
    assert error_m(in_air.positions, true) > 0.004


def test_claps_from_one_side_leave_much_undetermined() -> None:
    sources = around(14, 5)
    sources[:, :] = np.array([1.4, 0.1, 0.2]) + 0.05 * sources
    fit = refine(ways(sources, CORNERS), geometry(CORNERS, 0.0))
    assert fit.undetermined >= 4
    assert fit.deviations.max() > 0.01


def test_kept_positions_are_kept_and_explain_only_what_they_can() -> None:
    true = CORNERS + np.random.default_rng(6).normal(0, 0.01, CORNERS.shape)
    heard = ways(around(8, 6), true)
    kept = refine(heard, geometry(CORNERS, 0.0), prior_m=0.0)
    np.testing.assert_allclose(kept.positions, CORNERS - CORNERS.mean(axis=0), atol=1e-6)
    right = refine(heard, geometry(true, 0.0), prior_m=0.0)
    assert np.abs(right.residuals).max() < 3e-4 < 0.002 < np.sqrt((kept.residuals**2).mean())
