"""Low walls from a map's occupied cells: few boxes instead of many cells. Pure functions on arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid

#: Cells from this (0 to 100) are walls.
OCCUPIED = 65
HEIGHT_M = 0.4
#: Of more boxes the largest are drawn.
MOST_BOXES = 3000

#: Corners of a box by x, y, z of its least and greatest corner, and its faces but the bottom.
_CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)])
_FACES = np.array(
    [
        (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (1, 3, 7), (1, 7, 5), (3, 2, 6), (3, 6, 7), (2, 0, 4), (2, 4, 6)
    ]
)  # fmt: skip


def rectangles(occupied: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Rectangles (N, 4) of rows and columns ``[first row, first column, end row, end column[`` that together cover the
    true cells (H, W), each once: runs along the rows, joined where the next row has the same run."""
    padded = np.pad(occupied, ((0, 0), (1, 1))).astype(np.int8)
    steps = np.diff(padded, axis=1)
    rows, begins = np.nonzero(steps == 1)
    _, ends = np.nonzero(steps == -1)
    open_runs: dict[tuple[int, int], list[int]] = {}
    found: list[list[int]] = []
    for row, begin, end in zip(rows.tolist(), begins.tolist(), ends.tolist(), strict=True):
        before = open_runs.get((begin, end))
        if before is not None and before[2] == row:
            before[2] = row + 1
        else:
            open_runs[begin, end] = rectangle = [row, begin, row + 1, end]
            found.append(rectangle)
    return np.array(found, np.intp).reshape(-1, 4)


def wall_boxes(grid: OccupancyGrid | None) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Walls of ``grid``, :data:`HEIGHT_M` high: vertices (V, 3), m on the map, and faces (F, 3)."""
    found = rectangles(np.zeros((0, 0), np.bool_) if grid is None else grid.cells >= OCCUPIED)
    if grid is None or len(found) == 0:
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)
    if len(found) > MOST_BOXES:
        areas = (found[:, 2] - found[:, 0]) * (found[:, 3] - found[:, 1])
        found = found[np.argsort(-areas, kind="stable")[:MOST_BOXES]]
    low = np.array(grid.origin) + grid.resolution_m * found[:, 1::-1]
    high = np.array(grid.origin) + grid.resolution_m * found[:, :1:-1]
    bottom, top = np.zeros(len(found)), np.full(len(found), HEIGHT_M)
    ends = np.stack([np.column_stack([low, bottom]), np.column_stack([high, top])], axis=1)
    vertices = ends[:, _CORNERS, np.arange(3)]
    faces = _FACES + len(_CORNERS) * np.arange(len(found))[:, None, None]
    return vertices.reshape(-1, 3).astype(np.float32), faces.reshape(-1, 3).astype(np.uint32)


def box_ends(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least and greatest corner (N, 3), m, of each of the boxes with these ``vertices`` (V, 3)."""
    boxes = vertices.reshape(-1, len(_CORNERS), 3).astype(np.float64)
    return boxes[:, 0], boxes[:, -1]
