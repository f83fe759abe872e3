from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.landmarks.robot_pose import pose_by_landmark
from app.modules.perception.landmarks.sightings import Fused
from app.modules.perception.landmarks.types import Seen
from tests.modules.perception.landmarks.graphs import seen, turned

POSES = st.builds(Pose2, st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3))


def fused(p: tuple[float, float, float], heading: float, sigma_rad: float = 0.03) -> Fused:
    return Fused(np.array(p), 0.02**2 * np.eye(3), heading, sigma_rad)


@given(POSES, st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3))
def test_one_sighting_of_a_known_landmark_gives_the_pose(robot: Pose2, x: float, y: float, heading: float) -> None:
    found = pose_by_landmark(fused((x, y, 1.2), heading), seen(robot, (x, y, 1.2), heading))
    assert found is not None
    X_MB, covariance = found
    assert math.hypot(X_MB.x - robot.x, X_MB.y - robot.y) < 1e-6
    assert turned(X_MB.theta, robot.theta) < 1e-9
    assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_its_covariance_is_that_of_many_sightings() -> None:
    robot, at, heading = Pose2(1.0, -0.5, 0.7), (3.0, 1.0, 1.2), 3.0
    rng = np.random.default_rng(5)
    exact = seen(robot, at, heading, sigma_m=0.03)
    poses = []
    for _ in range(3000):
        assert exact.heading is not None
        p_BQ = exact.p_BQ + rng.normal(0, 0.03, 3)
        noisy = Seen(p_BQ, 0.03, exact.heading + rng.normal(0, 0.04), 0.04)
        there = fused(tuple((np.array(at) + rng.normal(0, 0.02, 3)).tolist()), heading + rng.normal(0, 0.03))
        found = pose_by_landmark(there, noisy)
        assert found is not None
        poses.append((found[0].x, found[0].y, found[0].theta))
    expected = np.cov(np.array(poses).T)
    found = pose_by_landmark(fused(at, heading), Seen(exact.p_BQ, 0.03, exact.heading, 0.04))
    assert found is not None
    np.testing.assert_allclose(found[1], expected, atol=0.12 * expected.max())


@pytest.mark.parametrize(("known", "measured"), [(None, 0.05), (0.03, None), (0.3, 0.3)])
def test_without_a_sure_heading_there_is_no_pose(known: float | None, measured: float | None) -> None:
    at = Fused(np.zeros(3), np.eye(3), None if known is None else 0.0, known)
    assert pose_by_landmark(at, Seen(np.ones(3), 0.03, None if measured is None else 0.0, measured)) is None
