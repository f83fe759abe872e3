"""Where something with legs stands that is no person: chairs, tables."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: Radius (m) of a spot.
SPOT_M = 0.2
#: Furniture not seen for so long (s) is forgotten: people stand in one place again and again.
_FORGOTTEN_S = 20.0


class Furniture:
    """Spots (2,) m in ``odom``, ``most`` of them, the newest kept."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._spots: list[tuple[float, Vector]] = []

    def note(self, stamp: float, at: Vector) -> None:
        """Something was seen standing ``at`` (2,) m."""
        others = [held for held in self._spots if math.dist(held[1], at) > SPOT_M]
        self._spots = [*others[-self._most + 1 :], (stamp, at)]

    def forget(self, at: Vector) -> None:
        """What stood ``at`` was a person."""
        self._spots = [held for held in self._spots if math.dist(held[1], at) > 2 * SPOT_M]

    def forget_old(self, stamp: float) -> None:
        """Forget what was not seen for long."""
        self._spots = [held for held in self._spots if stamp - held[0] < _FORGOTTEN_S]

    def at(self, place: Vector) -> bool:
        """Whether furniture is at ``place`` (2,) m."""
        return any(math.dist(spot, place) < SPOT_M for _, spot in self._spots)
