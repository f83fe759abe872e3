"""Geometry of grids: conversion between metres in a frame and rows and columns of an array."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid


@dataclass(frozen=True, slots=True)
class GridFrame:
    """A grid of ``rows`` x ``columns`` square cells of ``resolution_m``, its lower left corner at ``x``, ``y`` (m).

    Cell [row, column] covers x from ``x + column * resolution_m`` and y from ``y + row * resolution_m``.
    """

    x: float
    y: float
    resolution_m: float
    rows: int
    columns: int

    @staticmethod
    def of(grid: OccupancyGrid) -> GridFrame:
        """The geometry of ``grid``, in its own frame."""
        rows, columns = grid.cells.shape
        return GridFrame(grid.origin[0], grid.origin[1], grid.resolution_m, rows, columns)

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of the cell that contains the place (m); None outside the grid or for NaN."""
        if not (math.isfinite(x) and math.isfinite(y)):
            return None
        row = math.floor((y - self.y) / self.resolution_m)
        column = math.floor((x - self.x) / self.resolution_m)
        return (row, column) if 0 <= row < self.rows and 0 <= column < self.columns else None

    def middle(self, row: int, column: int) -> tuple[float, float]:
        """x and y (m) of a cell's middle."""
        return self.x + (column + 0.5) * self.resolution_m, self.y + (row + 0.5) * self.resolution_m

    def cells(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Rows and columns (N, 2) of ``points`` (N, 2) in m, and which of them lie in the grid (N,)."""
        corner = np.array([self.y, self.x])
        cells = np.floor((points[:, ::-1] - corner) / self.resolution_m).astype(np.int64)
        inside = ((cells >= 0) & (cells < np.array([self.rows, self.columns]))).all(axis=1)
        return cells, inside
