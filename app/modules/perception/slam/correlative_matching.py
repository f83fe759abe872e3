"""Correlative scan matching on a surfel grid: branch and bound over a pyramid (after Olson 2009, Hess 2016)."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2
from app.modules.perception.slam.likelihood_field import pyramid
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
        self.levels = pyramid(_field(grid.surfels, pad), levels)


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
def _field(surfels, pad) -> NDArray[np.uint8]:
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


@kernel("float64(uint8[:, ::1], int32[::1], int32[::1], int64, int64)")
def _score(field, cells_i, cells_j, shift_i, shift_j) -> float:
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
    levels, corner_i, corner_j, points, x, y, theta, window, window_rad, threshold
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
        c, s = math.cos(theta + (q - each_side) * step), math.sin(theta + (q - each_side) * step)
        for k in range(count):
            cells_i[q, k] = math.floor((c * points[k, 0] - s * points[k, 1] + x) / CELL_M) - corner_i
            cells_j[q, k] = math.floor((s * points[k, 0] + c * points[k, 1] + y) / CELL_M) - corner_j
        for di in range(-reach, reach + 1, stride):
            for dj in range(-reach, reach + 1, stride):
                score = _score(levels[top], cells_i[q], cells_j[q], di, dj)
                if score > threshold:
                    scores[made] = score
                    hypotheses[made, 0], hypotheses[made, 1], hypotheses[made, 2] = q, di, dj
                    made += 1
    best = threshold
    best_q = best_i = best_j = 0
    stack = np.empty((4 * top + 8, 4), np.int32)
    bounds = np.empty(4 * top + 8)
    for u in np.argsort(-scores[:made]):
        if scores[u] <= best:
            break
        depth = 1
        bounds[0] = scores[u]
        stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = hypotheses[u, 0], hypotheses[u, 1], hypotheses[u, 2], top
        while depth > 0:
            depth -= 1
            if bounds[depth] <= best:
                continue
            q, di, dj, level = stack[depth, 0], stack[depth, 1], stack[depth, 2], stack[depth, 3]
            if level == 0:
                best, best_q, best_i, best_j = bounds[depth], q, di, dj
                continue
            half = 1 << (level - 1)
            begin = depth
            for a in range(2):
                for b in range(2):
                    i, j = di + a * half, dj + b * half
                    if i > reach or j > reach:
                        continue
                    score = _score(levels[level - 1], cells_i[q], cells_j[q], i, j)
                    if score <= best:
                        continue
                    # In rising order, so that the most promising node is expanded first.
                    at = depth
                    while at > begin and bounds[at - 1] > score:
                        bounds[at] = bounds[at - 1]
                        for m in range(4):
                            stack[at, m] = stack[at - 1, m]
                        at -= 1
                    bounds[at] = score
                    stack[at, 0], stack[at, 1], stack[at, 2], stack[at, 3] = q, i, j, level - 1
                    depth += 1
    return best, x + best_i * CELL_M, y + best_j * CELL_M, theta + (best_q - each_side) * step
