"""From cells to a way that is driven: any-angle shortcuts where they cost no more, corners rounded, headings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.inflation import CostField


def smooth(field: CostField, points: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Points (M, 2) float64 m, ``spacing_m`` apart, from the first to the last of ``points`` (N >= 1, 2), no point or
    piece between in lethal cells if none of the given was."""
    raise NotImplementedError


def with_headings(points: NDArray[np.float64], first: float, last: float) -> NDArray[np.float64]:
    """Poses (M, 3) of points (M, 2): headings along the way; ``last`` (rad, NaN: along the way) at the end, ``first``
    if there is but one."""
    raise NotImplementedError
