"""Correlative scan matching on a surfel grid: branch and bound over a pyramid (after Olson 2009, Hess 2016)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2
from app.modules.perception.slam.surfels import CELL_M, SurfelGrid

#: Number of used readings: more cost time without better results.
_MOST_POINTS = 110
#: The angular step moves the farthest reading, up to this radius (m), by at most a cell.
_ARM_M = 12.0


class Pyramid:
    """Upper bounds of the score of a scan on a grid, for squares of 1, 2, 4 … cells."""

    def __init__(self, grid: SurfelGrid, levels: int) -> None:
        pad = 1 << (levels - 1)
        self.corner = (grid.corner[0] - pad, grid.corner[1] - pad)
        self.levels = _pyramid(_field(grid.surfels, pad), levels)


def sought(
    pyramid: Pyramid,
    points: NDArray[np.float32],
    guess: Pose2,
    window_m: float,
    window_rad: float,
    threshold: float,
) -> tuple[Pose2, float] | None:
    """The best pose of ``points`` (N, 4) within the windows around ``guess``, and its score in ]``threshold``, 1]; None
    if no pose exceeds ``threshold``. Accurate to a cell and an angular step; refine it by :func:`scan_matching.fitted`.
    """
    some = points[:: max(1, len(points) // _MOST_POINTS)]
    if not len(some):
        return None
    score, x, y, theta = _branch_and_bound(
        pyramid.levels,
        pyramid.corner[0],
        pyramid.corner[1],
        np.ascontiguousarray(some),
        guess.x,
        guess.y,
        guess.theta,
        window_m,
        window_rad,
        threshold,
    )
    return (Pose2(x, y, math.remainder(theta, math.tau)), score) if score > threshold else None


@kernel("uint8[:, ::1](float32[:, :, ::1], int64)")
def _field(surfels: NDArray[np.float32], pad: int) -> NDArray[np.uint8]:
    """Likelihood field of a reading: 255 in cells with a surfel, less beside them; ``pad`` more cells around."""
    rows, columns = surfels.shape[:2]
    field = np.zeros((rows + 2 * pad, columns + 2 * pad), np.uint8)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if surfels[i, j, 0] > 1e3:
                continue
            for a in range(-1, 2):
                for b in range(-1, 2):
                    value = 255 if a == 0 and b == 0 else (150 if a == 0 or b == 0 else 110)
                    if field[pad + i + a, pad + j + b] < value:
                        field[pad + i + a, pad + j + b] = value
    return field


@kernel("uint8[:, :, ::1](uint8[:, ::1], int64)")
def _pyramid(field: NDArray[np.uint8], levels: int) -> NDArray[np.uint8]:
    """Level l, cell [i, j]: the maximum of the 2^l x 2^l cells from [i, j] on."""
    rows, columns = field.shape
    out = np.zeros((levels, rows, columns), np.uint8)
    out[0] = field
    for level in range(1, levels):
        half = 1 << (level - 1)
        below = out[level - 1]
        for i in range(rows):
            i2 = min(i + half, rows - 1)
            for j in range(columns):
                j2 = min(j + half, columns - 1)
                out[level, i, j] = max(max(below[i, j], below[i2, j]), max(below[i, j2], below[i2, j2]))
    return out


@kernel("float64(uint8[:, ::1], int32[::1], int32[::1], int64, int64)")
def _score(
    field: NDArray[np.uint8], cells_i: NDArray[np.int32], cells_j: NDArray[np.int32], shift_i: int, shift_j: int
) -> float:
    rows, columns = field.shape
    total = 0
    for k in range(len(cells_i)):
        i = cells_i[k] + shift_i
        j = cells_j[k] + shift_j
        if i >= 0 and j >= 0 and i < rows and j < columns:
            total += field[i, j]
    return total / (255.0 * len(cells_i))


@kernel(
    "UniTuple(float64, 4)(uint8[:, :, ::1], int64, int64, float32[:, ::1], float64, float64, float64, float64, float64,"
    " float64)"
)
def _branch_and_bound(
    levels: NDArray[np.uint8],
    corner_i: int,
    corner_j: int,
    points: NDArray[np.float32],
    x: float,
    y: float,
    theta: float,
    window: float,
    window_rad: float,
    threshold: float,
) -> tuple[float, float, float, float]:
    """Best score and its pose; the score is ``threshold`` if no pose exceeds it."""
    count = len(points)
    arm = 1.0
    for k in range(count):
        arm = max(arm, math.hypot(points[k, 0], points[k, 1]))
    step = CELL_M / min(arm, _ARM_M)
    each_side = math.ceil(window_rad / step)
    angles = 2 * each_side + 1
    reach = math.ceil(window / CELL_M)
    top = len(levels) - 1
    while top > 0 and (1 << top) > reach:
        top -= 1
    stride = 1 << top
    cells_i = np.empty((angles, count), np.int32)
    cells_j = np.empty((angles, count), np.int32)
    most = angles * ((2 * reach) // stride + 2) ** 2
    scores = np.empty(most)
    hypotheses = np.empty((most, 3), np.int32)
    made = 0
    for q in range(angles):
        c = math.cos(theta + (q - each_side) * step)
        s = math.sin(theta + (q - each_side) * step)
        for k in range(count):
            cells_i[q, k] = math.floor((c * points[k, 0] - s * points[k, 1] + x) / CELL_M) - corner_i
            cells_j[q, k] = math.floor((s * points[k, 0] + c * points[k, 1] + y) / CELL_M) - corner_j
        for di in range(-reach, reach + 1, stride):
            for dj in range(-reach, reach + 1, stride):
                score = _score(levels[top], cells_i[q], cells_j[q], di, dj)
                if score > threshold:
                    scores[made] = score
                    hypotheses[made, 0] = q
                    hypotheses[made, 1] = di
                    hypotheses[made, 2] = dj
                    made += 1
    best = threshold
    best_q = best_i = best_j = 0
    stack = np.empty((4 * top + 8, 4), np.int32)
    bounds = np.empty(4 * top + 8)
    child_scores = np.empty(4)
    child_places = np.empty((4, 2), np.int32)
    for u in np.argsort(-scores[:made]):
        if scores[u] <= best:
            break
        depth = 1
        bounds[0] = scores[u]
        stack[0, 0] = hypotheses[u, 0]
        stack[0, 1] = hypotheses[u, 1]
        stack[0, 2] = hypotheses[u, 2]
        stack[0, 3] = top
        while depth > 0:
            depth -= 1
            if bounds[depth] <= best:
                continue
            q = stack[depth, 0]
            di = stack[depth, 1]
            dj = stack[depth, 2]
            level = stack[depth, 3]
            if level == 0:
                best = bounds[depth]
                best_q = q
                best_i = di
                best_j = dj
                continue
            half = 1 << (level - 1)
            children = 0
            for a in range(2):
                for b in range(2):
                    i = di + a * half
                    j = dj + b * half
                    if i > reach or j > reach:
                        continue
                    score = _score(levels[level - 1], cells_i[q], cells_j[q], i, j)
                    if score > best:
                        # In rising order, so that the most promising node is expanded first.
                        at = children
                        while at > 0 and child_scores[at - 1] > score:
                            child_scores[at] = child_scores[at - 1]
                            child_places[at] = child_places[at - 1]
                            at -= 1
                        child_scores[at] = score
                        child_places[at, 0] = i
                        child_places[at, 1] = j
                        children += 1
            for child in range(children):
                bounds[depth] = child_scores[child]
                stack[depth, 0] = q
                stack[depth, 1] = child_places[child, 0]
                stack[depth, 2] = child_places[child, 1]
                stack[depth, 3] = level - 1
                depth += 1
    return (
        best,
        x + best_i * CELL_M,
        y + best_j * CELL_M,
        theta + (best_q - each_side) * step,
    )
