"""Obstacles that the map does not know, remembered on the map for a while so that ways lead around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.modules.behaviors.navigation.costmap import Surroundings
from app.modules.behaviors.navigation.inflation import CostField


@dataclass(frozen=True, slots=True, eq=False)
class TemporaryObstacles:
    """``points`` (N, 2) float64 m on the map, each last seen at ``stamps`` (N,) float64 (robot's clock, s)."""

    points: NDArray[np.float64]
    stamps: NDArray[np.float64]

    @staticmethod
    def none() -> TemporaryObstacles:
        """Nothing remembered."""
        return TemporaryObstacles(np.empty((0, 2)), np.empty(0))


def remember(
    known: TemporaryObstacles,
    around: Surroundings,
    X_MO: Pose2,
    field: CostField,
    keep_s: float = 15.0,
) -> TemporaryObstacles:
    """``known`` with what stands around the robot now and is not on the map (``field``: without temporary obstacles).

    Inside the surroundings only what stands there now counts; outside, what was seen within ``keep_s`` before.
    """
    raise NotImplementedError
