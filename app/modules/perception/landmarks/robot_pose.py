"""The robot's pose by one landmark whose place and heading are known: a pure function."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.modules.perception.landmarks.sightings import Fused
from app.modules.perception.landmarks.types import Seen

#: Uncertainty of the heading (rad) above which the pose is none: 1 m at 3 m.
_MOST_SIGMA_RAD = 0.35


def pose_by_landmark(at: Fused, seen: Seen) -> tuple[Pose2, NDArray[np.float64]] | None:
    """The robot's pose in the frame of the landmark ``at``, and its covariance (3, 3) of x, y (m^2) and theta (rad^2),
    from one sighting of it; None where a heading is not known well enough."""
    if at.heading is None or at.heading_sigma is None or seen.heading is None or seen.heading_sigma is None:
        return None
    sigma_rad = math.hypot(at.heading_sigma, seen.heading_sigma)
    if sigma_rad > _MOST_SIGMA_RAD:
        return None
    theta = wrap_angle(at.heading - seen.heading)
    turned = Pose2(0.0, 0.0, theta).transform(seen.p_BQ[:2])
    x, y = (at.p[:2] - turned).tolist()
    # A wrong direction swings the robot around the landmark.
    swing = np.array([turned[1], -turned[0], 1.0])
    covariance = sigma_rad**2 * np.outer(swing, swing)
    covariance[:2, :2] += at.covariance[:2, :2] + seen.sigma_m**2 * np.eye(2)
    return Pose2(x, y, theta), covariance
