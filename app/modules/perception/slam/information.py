"""Information matrices (inverse covariance) of relative poses, and their transformation along edges.

The error of ``X_ab`` is a small motion of ``b`` in its own frame, as in GTSAM: x and y (m) along b's axes, theta (rad).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2

#: The upper triangle of the matrix, row by row: xx, xy, x theta, yy, y theta (1/m^2, 1/(m rad)), theta theta (1/rad^2).
Information = tuple[float, float, float, float, float, float]
Matrix = NDArray[np.float64]

_ROWS, _COLUMNS = np.triu_indices(3)


def diagonal(x: float, y: float, theta: float) -> Information:
    """Information of independent errors."""
    return x, 0.0, 0.0, y, 0.0, theta


def matrices(information: NDArray[np.float64]) -> Matrix:
    """(N, 3, 3) symmetric matrices of packed (N, 6)."""
    found = np.empty((len(information), 3, 3))
    found[:, _ROWS, _COLUMNS] = information
    found[:, _COLUMNS, _ROWS] = information
    return found


def matrix(information: Information) -> Matrix:
    """(3, 3) symmetric matrix of packed (6,)."""
    found: Matrix = matrices(np.array([information]))[0]
    return found


def packed(symmetric: Matrix) -> Information:
    """Packed form of a symmetric matrix (3, 3)."""
    xx, xy, xt, yy, yt, tt = symmetric[_ROWS, _COLUMNS].tolist()
    return xx, xy, xt, yy, yt, tt


def along(symmetric: Matrix, theta: float) -> Matrix:
    """The information along axes that are turned by ``theta`` (rad)."""
    c, s = math.cos(theta), math.sin(theta)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    found: Matrix = turn.T @ symmetric @ turn
    return found


def seen_from(information: Information, X_ab: Pose2) -> Information:
    """The information of ``X_ab``, as that of ``X_ba``."""
    moved = _moved(X_ab.inverse())
    return packed(moved.T @ matrix(information) @ moved)


def chained(first: Information, second: Information, X_bc: Pose2) -> Information:
    """The information of ``X_ac`` by ``X_ab`` (``first``) and ``X_bc`` (``second``): their covariances add."""
    moved = _moved(X_bc.inverse())
    covariance = np.linalg.inv(matrix(second)) + moved @ np.linalg.inv(matrix(first)) @ moved.T
    found = np.linalg.inv(covariance)
    return packed(0.5 * (found + found.T))


def variance_m2(information: Information) -> float:
    """Variance of the position (m^2), over all directions."""
    return float(np.linalg.inv(matrix(information))[:2, :2].trace())


def _moved(X_cb: Pose2) -> Matrix:
    """Adjoint: a small motion of b in its own frame as one of c, which is rigidly attached to it."""
    c, s = math.cos(X_cb.theta), math.sin(X_cb.theta)
    return np.array([[c, -s, X_cb.y], [s, c, -X_cb.x], [0.0, 0.0, 1.0]])
