"""Compiled kernels: rays on an occupancy grid."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel


@kernel("float32[::1](uint8[:,::1], uint8[:,::1], float64, float64, float64[::1], float64)")
def cast_grid(occupied, unknown, column, row, angles, reach) -> NDArray[np.float32]:
    """Length (cells) of rays from ``column``, ``row`` to halfway through an occupied cell; ``reach`` where they meet
    none, NaN where they enter unknown cells."""
    height, width = occupied.shape
    ranges = np.empty(len(angles), np.float32)
    for k in range(len(angles)):
        c, s = math.cos(angles[k]), math.sin(angles[k])
        ranges[k] = reach
        i, j = math.floor(column), math.floor(row)
        # Grid traversal (Amanatides and Woo, Eurographics 1987): from one side of a cell to the next.
        si, sj = (1 if c > 0 else -1), (1 if s > 0 else -1)
        # Bounded: on the side of a cell, infinitely many cells times none would be NaN.
        di = min(abs(1.0 / c), 1e30) if c != 0.0 else 1e30
        dj = min(abs(1.0 / s), 1e30) if s != 0.0 else 1e30
        ti = ((i + 1 - column) if c > 0 else (column - i)) * di
        tj = ((j + 1 - row) if s > 0 else (row - j)) * dj
        gone = 0.0
        while gone < reach:
            if i < 0 or j < 0 or i >= width or j >= height or unknown[j, i]:
                ranges[k] = np.nan
                break
            if occupied[j, i]:
                ranges[k] = gone + 0.5 * (min(ti, tj) - gone)
                break
            if ti < tj:
                gone = ti
                ti += di
                i += si
            else:
                gone = tj
                tj += dj
                j += sj
    return ranges
