"""The robot's pose on the map and its covariance: an extended Kalman filter that odometry predicts and scans update."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.modules.perception.slam.scan_matching import NOISE_M, ScanFit


class PoseEstimate:
    """Mean ``X_MB``, and ``covariance`` (3, 3) float64 of its x, y (m^2) and theta (rad^2), along the map's axes.

    ``covariance_before``: the covariance before the last prediction.
    """

    def __init__(self) -> None:
        self.X_MB = Pose2()
        self.covariance: NDArray[np.float64] = np.zeros((3, 3))
        self.covariance_before = self.covariance

    def predict(self, step: Pose2, sigma_m: float, sigma_rad: float) -> None:
        """Move by ``step`` of odometry, in ``base_link``, with its standard deviations (m, rad)."""
        before = self.X_MB
        self.X_MB = before @ step
        swing = np.eye(3)
        swing[0, 2] = before.y - self.X_MB.y
        swing[1, 2] = self.X_MB.x - before.x
        self.covariance_before = self.covariance
        self.covariance = swing @ self.covariance @ swing.T + np.diag([sigma_m**2, sigma_m**2, sigma_rad**2])

    def update(self, X_MS: Pose2, fit: ScanFit) -> None:
        """Take the pose of ``fit`` on a submap at ``X_MS``; a scan that lies badly counts for less."""
        self.X_MB = X_MS @ fit.X_SB
        c, s = math.cos(X_MS.theta), math.sin(X_MS.theta)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        information = turn @ fit.information @ turn.T / max(1.0, (fit.rms_m / NOISE_M) ** 2)
        self.covariance = np.linalg.inv(np.linalg.inv(self.covariance) + information)

    def squared_sigmas(self, X_MB: Pose2) -> float:
        """Squared Mahalanobis distance of ``X_MB`` from the mean; the covariance has to be invertible."""
        off = np.array([X_MB.x - self.X_MB.x, X_MB.y - self.X_MB.y, wrap_angle(X_MB.theta - self.X_MB.theta)])
        return float(off @ np.linalg.solve(self.covariance, off))
