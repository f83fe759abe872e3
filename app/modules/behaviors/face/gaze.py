"""Where the eyes look, by the body's kinematic model. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from app.base.kinematic_model import Joint, KinematicModel


class EyeGaze:
    """Angles (pan to the left, tilt up; rad) of eyes that turn by ``joint`` in the head, the link that carries it."""

    def __init__(self, model: KinematicModel, joint: Joint) -> None:
        self._model = model
        self._head = joint.parent
        # Midway between the eyes
        self._p_HE = joint.X_PJ.translation * np.array([1.0, 0.0, 1.0])

    def to_point(self, p_BP: NDArray[np.float64], positions: Mapping[str, float]) -> tuple[float, float]:
        """Towards the point ``p_BP`` (3,) m in the root link, from a head whose joints have ``positions``."""
        X_BH = self._model.pose(self._head, positions)
        return _angles(X_BH.inverse().transform(p_BP) - self._p_HE)

    def to_goal(self, goal: Mapping[str, float], positions: Mapping[str, float]) -> tuple[float, float]:
        """To where the head, on its way from ``positions`` to the joints' ``goal``, will look: the eyes are there
        before it."""
        ahead = self._model.pose(self._head, {**positions, **goal}).rotation[:, 0]
        return _angles(self._model.pose(self._head, positions).rotation.T @ ahead)


def _angles(direction: NDArray[np.float64]) -> tuple[float, float]:
    x, y, z = (float(value) for value in direction)
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))
