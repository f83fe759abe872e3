"""The pose's uncertainty: it grows along the way by odometry, and a scan takes away what it saw."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.pose_estimate import PoseEstimate
from app.modules.perception.slam.scan_matching import NOISE_M, ScanFit

STEPS = st.builds(Pose2, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))
SIGMAS = (0.02, 0.01)


def fit(X_SB: Pose2, information: tuple[float, float, float], rms_m: float = 0.5 * NOISE_M) -> ScanFit:
    return ScanFit(X_SB, 0.9, 1.0, rms_m, np.diag(information))


def driven(steps: list[Pose2]) -> PoseEstimate:
    estimate = PoseEstimate()
    for step in steps:
        estimate.predict(step, *SIGMAS)
    return estimate


@given(st.lists(STEPS, min_size=1, max_size=10), STEPS)
def test_odometry_makes_the_pose_less_sure_and_a_scan_makes_it_surer(steps: list[Pose2], off: Pose2) -> None:
    estimate = driven(steps)
    predicted = estimate.covariance
    assert np.linalg.eigvalsh(predicted).min() > 0
    assert np.linalg.det(predicted) > np.linalg.det(estimate.covariance_before)
    X_MS = Pose2(1.0, -2.0, 0.7)
    estimate.update(X_MS, fit(off, (1e4, 1e2, 1e3)))
    assert X_MS @ off == estimate.X_MB
    assert np.linalg.eigvalsh(predicted - estimate.covariance).min() > -1e-9


def test_a_wrong_heading_leads_aside_by_the_way_driven() -> None:
    estimate = PoseEstimate()
    estimate.predict(Pose2(0.0, 0.0, math.pi / 2), 0.0, 0.1)
    estimate.predict(Pose2(4.0, 0.0, 0.0), 0.0, 0.0)
    # It drove along y of the map: the error is along x.
    assert (estimate.X_MB.x, estimate.X_MB.y) == pytest.approx((0.0, 4.0))
    assert math.sqrt(estimate.covariance[0, 0]) == pytest.approx(0.4)
    assert estimate.covariance[1, 1] == pytest.approx(0.0, abs=1e-12)
    assert estimate.covariance[0, 2] < 0


def test_what_a_scan_says_is_said_along_the_submaps_axes() -> None:
    estimate = driven([Pose2(1.0, 0.0, 0.0)] * 10)
    before = estimate.covariance
    estimate.update(Pose2(0.0, 0.0, math.pi / 2), fit(Pose2(), (1e6, 1e-6, 1e-6)))
    assert estimate.covariance[1, 1] < 2e-6, "x of the submap is y of the map"
    assert estimate.covariance[0, 0] == pytest.approx(before[0, 0])


def test_a_scan_that_lies_badly_says_less() -> None:
    sigmas = []
    for rms_m in (0.5 * NOISE_M, NOISE_M, 3 * NOISE_M):
        estimate = driven([Pose2(1.0, 0.0, 0.0)])
        estimate.update(Pose2(), fit(Pose2(), (1e4, 1e4, 1e4), rms_m))
        sigmas.append(estimate.covariance[0, 0])
    assert sigmas[0] == sigmas[1] < sigmas[2]


def test_a_pose_is_as_far_in_sigmas_as_its_error_is_large() -> None:
    estimate = PoseEstimate()
    estimate.X_MB = Pose2(1.0, 2.0, math.pi - 0.05)
    estimate.covariance = np.diag([0.1**2, 0.2**2, 0.05**2])
    assert estimate.squared_sigmas(estimate.X_MB) == 0
    assert estimate.squared_sigmas(Pose2(1.3, 2.0, math.pi - 0.05)) == pytest.approx(9.0)
    assert estimate.squared_sigmas(Pose2(1.0, 2.0, -math.pi + 0.05)) == pytest.approx(4.0), "by the shorter way round"
