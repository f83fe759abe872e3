"""Motion of a person over ground: a Kalman filter of position and velocity, and the gated assignment of positions.

The state is x = (x, y, v_x, v_y) in ``odom``. People walk at nearly constant velocity and stop soon: without
measurements the velocity decays, so that a person who went out of sight is not expected ever farther away.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: Squared Mahalanobis distance that a right pair exceeds once in a thousand times.
GATE = 13.8
#: Cost above that of any pair inside the gate.
NEVER = 1e6
#: Density of the acceleration's noise (m²/s³), and time constant (s) of walking on.
_ACCELERATION, _WALKING_ON_S = 0.8, 1.5
#: Standard deviation (m/s) of the velocity at first.
_SPEED_MPS = 0.8


@dataclass(slots=True)
class Motion:
    """State ``x`` (4,) and covariance ``P`` (4, 4) at ``stamp``."""

    stamp: float
    x: Vector
    P: Vector

    @staticmethod
    def begin(stamp: float, at: Vector, covariance: Vector) -> Motion:
        """A motion that begins at ``at`` (2,) m with ``covariance`` (2, 2) m² and unknown velocity."""
        P = np.zeros((4, 4))
        P[:2, :2] = covariance
        P[2, 2] = P[3, 3] = _SPEED_MPS**2
        return Motion(stamp, np.array([at[0], at[1], 0.0, 0.0]), P)

    @property
    def at(self) -> Vector:
        """The place (2,) m."""
        return self.x[:2]

    @property
    def speed(self) -> float:
        """In m/s."""
        return math.hypot(self.x[2], self.x[3])

    def predict(self, stamp: float) -> None:
        """Predict the state at ``stamp``; for an older one it stays as it is."""
        dt = stamp - self.stamp
        if dt <= 0:
            return
        self.stamp = stamp
        keep = math.exp(-dt / _WALKING_ON_S)
        way = _WALKING_ON_S * (1 - keep)
        F = np.eye(4)
        F[0, 2] = F[1, 3] = way
        F[2, 2] = F[3, 3] = keep
        Q = np.zeros((4, 4))
        for place, speed in ((0, 2), (1, 3)):
            Q[place, place] = _ACCELERATION * dt * way**2 / 3
            Q[place, speed] = Q[speed, place] = _ACCELERATION * dt * way / 2
            Q[speed, speed] = _ACCELERATION * way
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + Q

    def update(self, at: Vector, covariance: Vector) -> None:
        """Take a measured place ``at`` (2,) m with ``covariance`` (2, 2) m²."""
        S = self.P[:2, :2] + covariance
        gain = np.linalg.solve(S, self.P[:2]).T
        self.x = self.x + gain @ (at - self.x[:2])
        left = np.eye(4)
        left[:, :2] -= gain
        self.P = left @ self.P @ left.T + gain @ covariance @ gain.T


def costs(motions: Sequence[Motion], places: Vector, covariances: Vector) -> Vector:
    """Costs (N, T), d² + ln |S|, of ``places`` (N, 2) with ``covariances`` (N, 2, 2) being those of T ``motions``;
    ``NEVER`` outside the gate."""
    if not motions or not len(places):
        return np.full((len(places), len(motions)), NEVER)
    at = np.array([motion.x[:2] for motion in motions])
    P = np.array([motion.P[:2, :2] for motion in motions])
    S = P[None] + covariances[:, None]
    determinant = S[..., 0, 0] * S[..., 1, 1] - S[..., 0, 1] * S[..., 1, 0]
    dx, dy = np.moveaxis(places[:, None] - at[None], -1, 0)
    squared = (S[..., 1, 1] * dx * dx - 2 * S[..., 0, 1] * dx * dy + S[..., 0, 0] * dy * dy) / determinant
    return np.where(squared <= GATE, squared + np.log(determinant), NEVER)


def assigned(cost: Vector) -> list[tuple[int, int]]:
    """Pairs (row, column) of least ``cost`` (N, T) together, none of ``NEVER`` (Kuhn, 1955)."""
    from scipy.optimize import linear_sum_assignment  # takes 0.3 s, too long for a start

    rows, columns = linear_sum_assignment(cost)
    return [(int(r), int(c)) for r, c in zip(rows, columns, strict=True) if cost[r, c] < NEVER / 2]


def prepare() -> None:
    """Load lazily imported packages in a module's thread, where the delay blocks no other work."""
    assigned(np.zeros((1, 1)))
