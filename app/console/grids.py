"""Grids cut to what is known of them, so that a picture holds no more than there is to see. Pure functions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.messages import OccupancyGrid


def known_part(grid: OccupancyGrid) -> OccupancyGrid:
    """``grid`` cut to the rectangle that holds everything known; where nothing is, to its first cell."""
    known = grid.cells >= 0
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if len(rows) == 0:
        return replace(grid, cells=grid.cells[:1, :1])
    top, left = int(rows[0]), int(columns[0])
    x, y = grid.origin
    return replace(
        grid,
        cells=grid.cells[top : int(rows[-1]) + 1, left : int(columns[-1]) + 1],
        origin=(x + left * grid.resolution_m, y + top * grid.resolution_m),
    )


def looks_as(grid: OccupancyGrid, other: OccupancyGrid) -> bool:
    """Whether two grids are the same to look at, whenever they were made."""
    return (
        grid.frame == other.frame
        and grid.origin == other.origin
        and grid.resolution_m == other.resolution_m
        and np.array_equal(grid.cells, other.cells)
    )
