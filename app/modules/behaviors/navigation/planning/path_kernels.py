"""Compiled kernels on paths through a cost field, in cells: (row, column) of a cell's middle are its indices."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel


@kernel("float64(float32[:,::1], float64, float64, float64, float64)")
def line_cost(cost, r0, c0, r1, c1) -> float:
    """Cost of the straight line, in cells of open floor: exact, cell by cell; +inf where it crosses a lethal one."""
    rows, columns = cost.shape
    dr, dc = r1 - r0, c1 - c0
    length = math.hypot(dr, dc)
    i, j = math.floor(r0 + 0.5), math.floor(c0 + 0.5)
    if i < 0 or j < 0 or i >= rows or j >= columns:
        return math.inf
    if length < 1e-12:
        return 0.0 if cost[i, j] < math.inf else math.inf
    step_i, step_j = (1 if dr > 0 else -1), (1 if dc > 0 else -1)
    # Parameters of the line at the next row and the next column, and the steps between them
    t_i, each_i = math.inf, math.inf
    if dr != 0.0:
        each_i = abs(1.0 / dr)
        t_i = (i + 0.5 * step_i - r0) / dr
    t_j, each_j = math.inf, math.inf
    if dc != 0.0:
        each_j = abs(1.0 / dc)
        t_j = (j + 0.5 * step_j - c0) / dc
    total, t = 0.0, 0.0
    while True:
        end = min(t_i, t_j, 1.0)
        # A line that only touches a corner does not cross the cell.
        if (end - t) * length > 1e-6:
            here = cost[i, j]
            if here == math.inf:
                return math.inf
            total += (end - t) * here
        if end >= 1.0:
            return total * length
        t = end
        if abs(t_i - t_j) * length < 1e-9:
            i, j, t_i, t_j = i + step_i, j + step_j, t_i + each_i, t_j + each_j
        elif t_i < t_j:
            i, t_i = i + step_i, t_i + each_i
        else:
            j, t_j = j + step_j, t_j + each_j
        if i < 0 or j < 0 or i >= rows or j >= columns:
            return math.inf if t * length < length - 1e-6 else total * length


@kernel("int64[::1](float32[:,::1], float64[:,::1])")
def shortcuts(cost, points) -> NDArray[np.int64]:
    """Indices of the points (N, 2) row, column to keep: the straight line between two costs no more than the points
    between."""
    n = len(points)
    so_far = np.zeros(n)
    for k in range(1, n):
        so_far[k] = so_far[k - 1] + line_cost(cost, points[k - 1, 0], points[k - 1, 1], points[k, 0], points[k, 1])
    kept = np.empty(n, dtype=np.int64)
    kept[0] = 0
    count, at = 1, 0
    while at < n - 1:
        good, bad, stride = at + 1, n, 2
        # Double the stride while it pays, then bisect between the last success and the first failure
        while at + stride < n or good < n - 1:
            k = min(at + stride, n - 1)
            if k <= good:
                break
            if line_cost(cost, points[at, 0], points[at, 1], points[k, 0], points[k, 1]) <= 1.001 * (
                so_far[k] - so_far[at]
            ):
                good = k
                stride *= 2
            else:
                bad = k
                break
        while bad - good > 1:
            k = (good + bad) // 2
            if k > n - 1:
                break
            if line_cost(cost, points[at, 0], points[at, 1], points[k, 0], points[k, 1]) <= 1.001 * (
                so_far[k] - so_far[at]
            ):
                good = k
            else:
                bad = k
        at = good
        kept[count] = at
        count += 1
    return kept[:count].copy()


@kernel("int64(float32[:,::1], float64[:,::1], float64, int64)")
def refine(cost, points, stride, rounds) -> int:
    """Move the points (N, 2) row, column in place so that the path costs less; returns the number of moves.

    Each point in turn is placed level with its neighbours' middle and ``stride`` (cells), or half of it, to the left or
    right, where the two pieces beside it cost least: coordinate descent to a local minimum. The ends stay.
    """
    n = len(points)
    active = np.ones(n, dtype=np.uint8)
    moves = 0
    for _ in range(rounds):
        moved = 0
        for k in range(1, n - 1):
            if not active[k]:
                continue
            active[k] = 0
            r0, c0, r1, c1 = points[k - 1, 0], points[k - 1, 1], points[k + 1, 0], points[k + 1, 1]
            length = math.hypot(r1 - r0, c1 - c0)
            if length < 1e-6:
                continue
            normal_r, normal_c = -(c1 - c0) / length, (r1 - r0) / length
            middle_r, middle_c = 0.5 * (r0 + r1), 0.5 * (c0 + c1)
            out = (points[k, 0] - middle_r) * normal_r + (points[k, 1] - middle_c) * normal_c
            least = line_cost(cost, r0, c0, points[k, 0], points[k, 1])
            least += line_cost(cost, points[k, 0], points[k, 1], r1, c1)
            # A negligible gain is not worth new searches of the neighbours.
            least -= 1e-4 * length
            best = math.inf
            for choice in range(4):
                t = out
                if choice == 1:
                    t = out - stride
                elif choice == 2:
                    t = out + stride
                elif choice == 3:
                    t = 0.5 * out
                r, c = middle_r + t * normal_r, middle_c + t * normal_c
                total = line_cost(cost, r0, c0, r, c)
                if total < least:
                    total += line_cost(cost, r, c, r1, c1)
                if total < least:
                    least, best = total, t
            if best < math.inf:
                points[k, 0], points[k, 1] = middle_r + best * normal_r, middle_c + best * normal_c
                active[k - 1], active[k], active[k + 1] = 1, 1, 1
                moved += 1
        moves += moved
        if not moved:
            break
    return moves


@kernel("int64(float32[:,::1], float32[:,::1], float64[:,::1], int64, float64, float64)")
def relax(cost, clearance, points, rounds, lethal, keep) -> int:
    """Round the corners of ``points`` (N, 2) row, column in place; returns the number of moves.

    Each point moves to the middle between its neighbours as long as both pieces beside it stay free of lethal cells and
    keep the share ``keep`` of the point's clearance beyond ``lethal`` (m). The ends stay.
    """
    n = len(points)
    needed = np.empty(n)
    for k in range(n):
        here = clearance[math.floor(points[k, 0] + 0.5), math.floor(points[k, 1] + 0.5)]
        needed[k] = lethal + keep * (here - lethal)
    active = np.ones(n, dtype=np.uint8)
    moves = 0
    for _ in range(rounds):
        moved = 0
        for k in range(1, n - 1):
            if not active[k]:
                continue
            active[k] = 0
            r = 0.5 * (points[k - 1, 0] + points[k + 1, 0])
            c = 0.5 * (points[k - 1, 1] + points[k + 1, 1])
            if abs(r - points[k, 0]) + abs(c - points[k, 1]) < 2e-3:
                continue
            if clearance[math.floor(r + 0.5), math.floor(c + 0.5)] < needed[k]:
                continue
            if (
                line_cost(cost, points[k - 1, 0], points[k - 1, 1], r, c) == math.inf
                or line_cost(cost, r, c, points[k + 1, 0], points[k + 1, 1]) == math.inf
            ):
                continue
            points[k, 0], points[k, 1] = r, c
            active[k - 1], active[k], active[k + 1] = 1, 1, 1
            moved += 1
        moves += moved
        if not moved:
            break
    return moves


@kernel("int64(float32[:,::1], float64[:,::1], int64, int64)")
def first_lethal(cost, points, first, last) -> int:
    """Index of the first of ``points`` (N, 2) row, column from ``first`` on that a lethal cell precedes or contains;
    -1: none.

    Lethal cells right at ``first`` are allowed: the path may lead out of them.
    """
    free = False
    for k in range(first, last + 1):
        i, j = math.floor(points[k, 0] + 0.5), math.floor(points[k, 1] + 0.5)
        inside = 0 <= i < cost.shape[0] and 0 <= j < cost.shape[1]
        here = inside and cost[i, j] < math.inf
        if free and not here:
            return k
        if free and line_cost(cost, points[k - 1, 0], points[k - 1, 1], points[k, 0], points[k, 1]) == math.inf:
            return k
        free = free or here
    return -1 if free else last


@kernel("int64[:,::1](uint8[:,::1], float32[:,::1], int64, int64, float64, uint8)")
def escape(layers, cost, row, column, radius, through) -> NDArray[np.int64]:
    """Cells (N, 2) from (row, column) to the nearest that is not lethal within ``radius`` (cells), each touching the
    one before. Cells occupied by obstacles (of the layers ``through``, bits) are crossed only from
    such a cell."""
    rows, columns = cost.shape
    reach = int(radius) + 1
    top, left = max(row - reach, 0), max(column - reach, 0)
    height, width = min(row + reach + 1, rows) - top, min(column + reach + 1, columns) - left
    size = height * width
    far = np.full(size, np.inf)
    came = np.full(size, -1, dtype=np.int64)
    done = np.zeros(size, dtype=np.uint8)
    start = (row - top) * width + column - left
    inside = (int(layers[row, column]) & int(through)) != 0
    far[start] = 0.0
    heap = [(0.0, start)]
    end = -1
    while heap:
        key, u = heapq.heappop(heap)
        if done[u]:
            continue
        done[u] = 1
        i, j = u // width, u % width
        if cost[top + i, left + j] < np.inf:
            end = u
            break
        for di in range(-1, 2):
            for dj in range(-1, 2):
                a, b = i + di, j + dj
                if a < 0 or b < 0 or a >= height or b >= width or (di == 0 and dj == 0):
                    continue
                v = a * width + b
                wall = (int(layers[top + a, left + b]) & int(through)) != 0
                if done[v] or (wall and not inside):
                    continue
                length = key + math.hypot(di, dj) * (4.0 if wall else 1.0)
                if length < far[v] and math.hypot(top + a - row, left + b - column) <= radius:
                    far[v], came[v] = length, u
                    heapq.heappush(heap, (length, v))
    if end < 0:
        return np.empty((0, 2), dtype=np.int64)
    n, u = 1, end
    while came[u] >= 0:
        u = came[u]
        n += 1
    cells = np.empty((n, 2), dtype=np.int64)
    u = end
    for k in range(n - 1, -1, -1):
        cells[k, 0], cells[k, 1] = top + u // width, left + u % width
        u = came[u]
    return cells
