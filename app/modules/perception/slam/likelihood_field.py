"""Likelihood field of a saved map (Thrun, Burgard, Fox 2005, 6.4): distance transform of the occupied cells, for scan
matching and global search. The search over the whole map is branch and bound on a pyramid of maxima (Olson 2009, Hess
et al. 2016) and returns all poses of nearly the best score.
"""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.messages import OccupancyGrid

#: Least value of an occupied cell, and greatest value of a free one.
OCCUPIED, FREE = 50, 25
#: Step of the search (m), and greatest range of used readings (m).
STEP_M, LONGEST_M = 0.1, 12.0
#: Distance (m) from an occupied cell at which a ray's end scores 0.6.
SIGMA_M = 0.1
#: Distance (m) from the middle of an occupied cell within which a ray's end fits.
NEAR_M = 0.12
#: Greatest distance in the field (m).
FURTHEST_M = 1.0
#: Levels of the pyramid; the widest step is 2^(levels − 1) steps.
LEVELS = 6
#: Greatest number of returned poses.
MOST_LEAVES = 20_000


class LikelihoodField:
    """The field of one grid; immutable. Construction takes about 50 ms for 50 x 50 m."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self.cell_m = grid.resolution_m
        self.origin = grid.origin
        occupied = grid.cells >= OCCUPIED
        known = cv2.dilate((grid.cells >= 0).astype(np.uint8), np.ones((7, 7), np.uint8))
        far = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        #: (H, W) float32: distance (m) of each cell to the nearest occupied one, at most FURTHEST_M.
        self.far = np.minimum(np.asarray(far, np.float32) * np.float32(self.cell_m), np.float32(FURTHEST_M))
        if not occupied.any():
            self.far[:] = FURTHEST_M
        #: Known cells, dilated.
        self.known: NDArray[np.uint8] = np.asarray(known, np.uint8)
        self.occupied: NDArray[np.uint8] = occupied.astype(np.uint8)
        self._make_pyramids((grid.cells >= 0) & (grid.cells <= FREE))

    def _make_pyramids(self, free: NDArray[np.bool_]) -> None:
        fold = max(1, round(STEP_M / self.cell_m))
        self._step = fold * self.cell_m
        score = np.round(255 * np.exp(-0.5 * (self.far / SIGMA_M) ** 2)).astype(np.uint8)
        score[self.far >= FURTHEST_M] = 0
        self._margin = math.ceil(LONGEST_M / self._step) + 2
        self._scores = pyramid(_folded(score, fold, self._margin), LEVELS)
        self._free = pyramid(_folded(free.astype(np.uint8), fold, self._margin), LEVELS)

    def search(
        self, points: NDArray[np.float64], floor: float, margin: float, headings: int = 0
    ) -> NDArray[np.float64]:
        """All poses (M, 4) x, y, heading and score of nearly the best fit of ``points`` (N, 2), m in ``base_link``.

        ``floor``: least score (0 to 1); ``margin``: greatest difference to the best score; best first. Poses are on
        free floor. ``headings``: number of headings around the circle; 0: by the range of the points.
        """
        points = np.ascontiguousarray(points[np.hypot(*points.T) < LONGEST_M])
        if not len(points):
            return np.zeros((0, 4))
        reach = float(np.percentile(np.hypot(*points.T), 80))
        count = headings or math.ceil(math.tau * max(reach, 2.0) / self._step)
        angles = np.arange(count, dtype=np.float64) * (math.tau / count) - math.pi
        found: NDArray[np.float64] = search_leaves(
            self._scores, self._free, points, angles, self._step, self._margin, floor, margin, MOST_LEAVES
        )
        found = found[np.argsort(-found[:, 3], kind="stable")]
        found[:, :2] += np.array(self.origin)
        return found

    def refine(self, points: NDArray[np.float64], pose: NDArray[np.float64], rounds: int = 12) -> NDArray[np.float64]:
        """``pose`` (x, y, heading) moved to the local best fit of ``points`` (Gauss-Newton on the distances)."""
        return descend(self.far, points, pose, self.cell_m, self.origin[0], self.origin[1], rounds)

    def explained(
        self, points: NDArray[np.float64], sensor_xy: NDArray[np.float64], pose: NDArray[np.float64]
    ) -> NDArray[np.int8]:
        """How the map explains each of ``points``, seen from ``sensor_xy`` (m in ``base_link``), with the body at
        ``pose``.

        1: an obstacle is there, in line of sight; 0: free, or occluded by another obstacle; −1: unknown.
        """
        found: NDArray[np.int8] = explain(
            self.far, self.known, self.occupied, points, sensor_xy, pose, self.cell_m, self.origin[0], self.origin[1]
        )
        return found

    def is_free(self, pose: NDArray[np.float64]) -> bool:
        """Whether there is free floor at ``pose``, or within a step of it."""
        i = math.floor((pose[0] - self.origin[0]) / self._step) + self._margin
        j = math.floor((pose[1] - self.origin[1]) / self._step) + self._margin
        level = self._free[0]
        inside = 0 < j < level.shape[0] - 1 and 0 < i < level.shape[1] - 1
        return bool(inside and level[j - 1 : j + 2, i - 1 : i + 2].any())


def _folded(values: NDArray[np.uint8], fold: int, margin: int) -> NDArray[np.uint8]:
    """The maximum of each ``fold`` x ``fold`` values, with ``margin`` zeros around."""
    height, width = values.shape
    whole = np.pad(values, ((0, -height % fold), (0, -width % fold)))
    blocks = whole.reshape(whole.shape[0] // fold, fold, whole.shape[1] // fold, fold)
    return np.pad(blocks.max(axis=(1, 3)), margin)


@kernel("uint8[:,:,::1](uint8[:,::1], int64)")
def pyramid(values, levels) -> NDArray[np.uint8]:
    """(levels, H, W): at level l, the maximum of the 2^l x 2^l cells from each on."""
    height, width = values.shape
    out = np.zeros((levels, height, width), np.uint8)
    for j in range(height):
        for i in range(width):
            out[0, j, i] = values[j, i]
    for level in range(1, levels):
        half = 1 << (level - 1)
        below, here = out[level - 1], out[level]
        for j in range(height):
            j2 = min(j + half, height - 1)
            for i in range(width):
                i2 = min(i + half, width - 1)
                here[j, i] = max(max(below[j, i], below[j, i2]), max(below[j2, i], below[j2, i2]))
    return out


@kernel("float64(uint8[:,::1], int32[::1], int32[::1], int64, int64)")
def _score(values, columns, rows, i, j) -> float:
    total = 0
    for k in range(len(columns)):
        total += values[j + rows[k], i + columns[k]]
    return total / (255.0 * len(columns))


@kernel(
    "float64[:,::1](uint8[:,:,::1], uint8[:,:,::1], float64[:,::1], float64[::1], float64, int64, float64, float64,"
    " int64)"
)
def search_leaves(scores, free, points, angles, step, margin, floor, slack, capacity) -> NDArray[np.float64]:
    """x, y (m from the grid's corner), heading and score of every pose that scores ``floor`` and is at most ``slack``
    below the best."""
    levels, height, width = scores.shape
    top = levels - 1
    wide = 1 << top
    turns, count = len(angles), len(points)
    columns = np.empty((turns, count), np.int32)
    rows = np.empty((turns, count), np.int32)
    for q in range(turns):
        c, s = math.cos(angles[q]), math.sin(angles[q])
        for k in range(count):
            columns[q, k] = math.floor(0.5 + (c * points[k, 0] - s * points[k, 1]) / step)
            rows[q, k] = math.floor(0.5 + (s * points[k, 0] + c * points[k, 1]) / step)
    across = (width - 2 * margin + wide - 1) // wide
    along = (height - 2 * margin + wide - 1) // wide
    bounds = np.empty(turns * across * along)
    starts = np.empty((turns * across * along, 3), np.int32)
    found = 0
    for q in range(turns):
        for b in range(along):
            for a in range(across):
                i, j = margin + a * wide, margin + b * wide
                if free[top, j, i] == 0:
                    continue
                bound = _score(scores[top], columns[q], rows[q], i, j)
                if bound >= floor:
                    bounds[found] = bound
                    starts[found, 0], starts[found, 1], starts[found, 2] = q, i, j
                    found += 1
    order = np.argsort(-bounds[:found])
    leaves = np.empty((capacity, 4))
    kept = 0
    best = floor
    stack = np.empty((4 * levels + 4, 4), np.int32)
    stack_bounds = np.empty(4 * levels + 4)
    for at in range(found):
        first = order[at]
        if bounds[first] < max(floor, best - slack) or kept == capacity:
            break
        stack_bounds[0] = bounds[first]
        stack[0, 0], stack[0, 1], stack[0, 2] = starts[first, 0], starts[first, 1], starts[first, 2]
        stack[0, 3] = top
        depth = 1
        while depth > 0 and kept < capacity:
            depth -= 1
            bound = stack_bounds[depth]
            if bound < max(floor, best - slack):
                continue
            q, i, j, level = stack[depth, 0], stack[depth, 1], stack[depth, 2], stack[depth, 3]
            if level == 0:
                best = max(best, bound)
                leaves[kept, 0], leaves[kept, 1] = (i - margin + 0.5) * step, (j - margin + 0.5) * step
                leaves[kept, 2], leaves[kept, 3] = angles[q], bound
                kept += 1
                continue
            half = 1 << (level - 1)
            begin = depth
            for b in range(2):
                for a in range(2):
                    u, v = i + a * half, j + b * half
                    if u >= width - margin or v >= height - margin or free[level - 1, v, u] == 0:
                        continue
                    value = _score(scores[level - 1], columns[q], rows[q], u, v)
                    if value < max(floor, best - slack):
                        continue
                    # The best of the four on top of the stack.
                    place = depth
                    while place > begin and stack_bounds[place - 1] > value:
                        stack_bounds[place] = stack_bounds[place - 1]
                        for m in range(4):
                            stack[place, m] = stack[place - 1, m]
                        place -= 1
                    stack_bounds[place] = value
                    stack[place, 0], stack[place, 1], stack[place, 2], stack[place, 3] = q, u, v, level - 1
                    depth += 1
    good: NDArray[np.float64] = leaves[:kept][leaves[:kept, 3] >= max(floor, best - slack)]
    return good


@kernel("UniTuple(float64, 3)(float64[:,::1], float64[::1])")
def _solved(h, g) -> tuple[float, float, float]:
    """x of h x = g, for h (3, 3) symmetric and positive definite: h = L D L^T (Golub and Van Loan, 4.1).

    LAPACK's solver, as numba binds it, takes seconds to compile.
    """
    l10, l20 = h[1, 0] / h[0, 0], h[2, 0] / h[0, 0]
    d1 = h[1, 1] - l10 * h[1, 0]
    l21 = (h[2, 1] - l20 * h[1, 0]) / d1
    d2 = h[2, 2] - l20 * h[2, 0] - l21 * l21 * d1
    z1 = g[1] - l10 * g[0]
    x2 = (g[2] - l20 * g[0] - l21 * z1) / d2
    x1 = z1 / d1 - l21 * x2
    return g[0] / h[0, 0] - l10 * x1 - l20 * x2, x1, x2


@kernel("float64[::1](float32[:,::1], float64[:,::1], float64[::1], float64, float64, float64, int64)")
def descend(far, points, pose, cell, x0, y0, rounds) -> NDArray[np.float64]:
    """Gauss-Newton on the distances at the points, with a robust weight (Cauchy, 0.1 m)."""
    height, width = far.shape
    x, y, theta = pose[0], pose[1], pose[2]
    for _ in range(rounds):
        c, s = math.cos(theta), math.sin(theta)
        # Damped: a corridor gives no information along it.
        h, g = np.eye(3), np.zeros(3)
        used = 0
        for k in range(len(points)):
            rx, ry = c * points[k, 0] - s * points[k, 1], s * points[k, 0] + c * points[k, 1]
            u, v = (x + rx - x0) / cell - 0.5, (y + ry - y0) / cell - 0.5
            i, j = math.floor(u), math.floor(v)
            if i < 0 or j < 0 or i >= width - 1 or j >= height - 1:
                continue
            a, b = u - i, v - j
            d00, d10, d01, d11 = far[j, i], far[j, i + 1], far[j + 1, i], far[j + 1, i + 1]
            d = (1 - b) * ((1 - a) * d00 + a * d10) + b * ((1 - a) * d01 + a * d11)
            if d > 0.8:
                continue
            dx = ((1 - b) * (d10 - d00) + b * (d11 - d01)) / cell
            dy = ((1 - a) * (d01 - d00) + a * (d11 - d10)) / cell
            w = 1.0 / (1.0 + (d / 0.1) ** 2)
            slope = (dx, dy, -ry * dx + rx * dy)
            for m in range(3):
                g[m] += w * slope[m] * d
                for n in range(3):
                    h[m, n] += w * slope[m] * slope[n]
            used += 1
        if used < 10:
            break
        step = _solved(h, g)
        x, y, theta = x - step[0], y - step[1], theta - step[2]
        if abs(step[0]) + abs(step[1]) < 1e-4 and abs(step[2]) < 1e-5:
            break
    return np.array([x, y, theta])


@kernel(
    "int8[::1](float32[:,::1], uint8[:,::1], uint8[:,::1], float64[:,::1], float64[::1], float64[::1], float64,"
    " float64, float64)"
)
def explain(far, known, occupied, points, sensor_xy, pose, cell, x0, y0) -> NDArray[np.int8]:
    """See :meth:`LikelihoodField.explained`: rays are traced in half cells up to 0.4 m before their ends."""
    height, width = far.shape
    c, s = math.cos(pose[2]), math.sin(pose[2])
    ex = pose[0] + c * sensor_xy[0] - s * sensor_xy[1] - x0
    ey = pose[1] + s * sensor_xy[0] + c * sensor_xy[1] - y0
    said = np.empty(len(points), np.int8)
    for k in range(len(points)):
        x = pose[0] + c * points[k, 0] - s * points[k, 1] - x0
        y = pose[1] + s * points[k, 0] + c * points[k, 1] - y0
        i, j = math.floor(x / cell), math.floor(y / cell)
        if i < 0 or j < 0 or i >= width or j >= height or known[j, i] == 0:
            said[k] = -1
            continue
        if far[j, i] > NEAR_M:
            said[k] = 0
            continue
        said[k] = 1
        length = math.hypot(x - ex, y - ey)
        for n in range(int(2 * (length - 0.4) / cell)):
            share = n * 0.5 * cell / length
            i, j = math.floor((ex + share * (x - ex)) / cell), math.floor((ey + share * (y - ey)) / cell)
            if i >= 0 and j >= 0 and i < width and j < height and occupied[j, i]:
                said[k] = 0
                break
    return said
