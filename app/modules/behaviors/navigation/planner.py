"""A* over a cost field, on 8 neighbours, fast on whole maps (thesis 4.2.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.inflation import CostField


def cheapest_way(field: CostField, start: tuple[int, int], goal: tuple[int, int]) -> NDArray[np.int64] | None:
    """Cells (N, 2) row, column from ``start`` to ``goal``, each a neighbour of the last, none lethal; None: no way."""
    raise NotImplementedError


def cost_to_go(field: CostField, goal: tuple[int, int]) -> NDArray[np.float32]:
    """What the cheapest way from each cell to ``goal`` costs (metres in the open), +inf where none leads; (H, W)."""
    raise NotImplementedError
