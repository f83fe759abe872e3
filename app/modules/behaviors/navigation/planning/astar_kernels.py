"""Compiled kernels: A* over a grid whose cells are pooled into blocks.

Blocks of 2 x 2 cells are the nodes. All cells of one block touch each other, so two adjacent blocks are connected
exactly where their free cells touch: pooling neither loses nor invents a path, and a quarter of the nodes remain.

Costs are small integers, so that the queue is a ring of buckets (Dial, 1969) instead of a heap.
"""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel

#: Cost of a straight and of a diagonal step of two cells on open floor, in eighths of a metre's cost.
_STRAIGHT, _DIAGONAL = 32, 45
#: Greatest cost per metre: the cost of a step stays below the length of the bucket ring.
_DEAREST = 64.0
_RING = 8192


@kernel("int32[:,::1](float32[:,::1], uint8[:,::1], uint8, float64, int64, int64)")
def pool(cost, layers, passable, fee, odd_row, odd_column) -> NDArray[np.int32]:
    """Blocks of the field, with a border of one block: 8 * mean cost << 4 | free cells of the four (bits); 0: none.

    ``cost`` (H, W) float32 per metre. Where it is infinite and ``passable`` (bits) covers all layers that make it so, a
    metre costs ``fee``. ``odd_row``, ``odd_column`` (0 or 1): whether the first row and column form blocks alone.
    """
    rows, columns = cost.shape
    height, width = (rows + odd_row + 1) // 2, (columns + odd_column + 1) // 2
    blocks = np.zeros((height + 2, width + 2), dtype=np.int32)
    shut = ~int(passable) & 0x70
    for r in range(height):
        for c in range(width):
            mask, total, free = 0, 0.0, 0
            for bit in range(4):
                i, j = 2 * r - odd_row + (bit >> 1), 2 * c - odd_column + (bit & 1)
                if i < 0 or j < 0 or i >= rows or j >= columns:
                    continue
                price = cost[i, j]
                if price == np.inf:
                    if passable == 0 or int(layers[i, j]) & shut:
                        continue
                    price = fee
                mask |= 1 << bit
                total += min(price, _DEAREST)
                free += 1
            if mask:
                blocks[r + 1, c + 1] = (np.int32(total / free * 8.0 + 0.5) << 4) | mask
    return blocks


@kernel("Tuple((int32[::1], uint8[::1]))(int32[:,::1], int64, int64)")
def search(blocks, start, goal) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Least cost of a path from block ``start`` to each block (flat, int32; the largest value: not reached), and the
    direction (0 to 7, of ``joined``) of its last step (255: none).

    Indices are flat, of ``blocks`` with its border. With a ``goal`` (else -1) the search ends there, and most costs are
    not final; without, or if the goal is not reached, costs of all reachable blocks are final.
    """
    width = blocks.shape[1]
    flat = blocks.ravel()
    size = len(flat)
    far = np.int32(2**31 - 1)
    cost = np.full(size, far, dtype=np.int32)
    came = np.full(size, 255, dtype=np.uint8)
    if not flat[start]:
        return cost, came
    # Bucket b holds, as a doubly linked list, all open blocks with estimated total cost b, modulo the ring.
    ring = np.full(_RING, -1, dtype=np.int32)
    following = np.empty(size, dtype=np.int32)
    before = np.empty(size, dtype=np.int32)
    total = np.empty(size, dtype=np.int32)
    closed = np.zeros(size, dtype=np.uint8)
    offsets = np.array([1, -1, width, -width, width + 1, width - 1, -width + 1, -width - 1])
    # Cells (bits 1 2 in the first row, 4 8 in the second) of this block and of the next that touch, by direction
    mine = np.array([2 | 8, 1 | 4, 4 | 8, 1 | 2, 8, 4, 2, 1], dtype=np.int32)
    theirs = np.array([1 | 4, 2 | 8, 1 | 2, 4 | 8, 1, 2, 4, 8], dtype=np.int32)
    goal_row, goal_column = goal // width, goal % width
    cost[start] = 0
    at = 0
    if goal >= 0:
        rows, columns = abs(start // width - goal_row), abs(start % width - goal_column)
        both = min(rows, columns)
        at = _STRAIGHT * (max(rows, columns) - both) + _DIAGONAL * both
    total[start] = at
    ring[at & (_RING - 1)] = start
    following[start] = before[start] = -1
    waiting = 1
    while waiting:
        while ring[at & (_RING - 1)] < 0:
            at += 1
        u = ring[at & (_RING - 1)]
        after = following[u]
        ring[at & (_RING - 1)] = after
        if after >= 0:
            before[after] = -1
        waiting -= 1
        closed[u] = 1
        if u == goal:
            break
        block = flat[u]
        price = block >> 4
        so_far = cost[u]
        row, column = 0, 0
        if goal >= 0:
            row, column = u // width, u % width
        for d in range(8):
            v = u + offsets[d]
            other = flat[v]
            if closed[v] or not (block & mine[d]) or not (other & theirs[d]):
                continue
            step = price + (other >> 4)
            known = so_far + (step * 2 if d < 4 else (step * 181) >> 6)
            if known >= cost[v]:
                continue
            if cost[v] != far:
                # The block is in another bucket already.
                ahead, after = before[v], following[v]
                if ahead >= 0:
                    following[ahead] = after
                else:
                    ring[total[v] & (_RING - 1)] = after
                if after >= 0:
                    before[after] = ahead
                waiting -= 1
            estimate = known
            if goal >= 0:
                rows = abs(row + (d == 2 or d == 4 or d == 5) - (d == 3 or d >= 6) - goal_row)
                columns = abs(column + (d == 0 or d == 4 or d == 6) - (d == 1 or d == 5 or d == 7) - goal_column)
                both = min(rows, columns)
                # Admissible (at most the open-floor cost) and consistent (falls by at most a step's cost).
                estimate += _STRAIGHT * (max(rows, columns) - both) + _DIAGONAL * both
            cost[v] = known
            came[v] = d
            total[v] = max(estimate, at)
            head = ring[total[v] & (_RING - 1)]
            following[v], before[v] = head, -1
            if head >= 0:
                before[head] = v
            ring[total[v] & (_RING - 1)] = v
            waiting += 1
    return cost, came


@kernel(
    "int64[:,::1](int32[:,::1], uint8[::1], int64, UniTuple(int64, 2), UniTuple(int64, 2), float32[:,::1], float64,"
    " int64, int64)"
)
def trace(blocks, came, end, first, last, cost, fee, odd_row, odd_column) -> NDArray[np.int64]:
    """The cells (N, 2), each touching the one before, from cell ``first`` to cell ``last`` through the blocks of the
    path to block ``end`` that ``search`` found: the cheapest such cells of each block."""
    width = blocks.shape[1]
    offsets = np.array([1, -1, width, -width, width + 1, width - 1, -width + 1, -width - 1])
    count, u = 1, end
    while came[u] != 255:
        u -= offsets[came[u]]
        count += 1
    chain = np.empty(count, dtype=np.int64)
    u = end
    for k in range(count - 1, -1, -1):
        chain[k] = u
        if k:
            u -= offsets[came[u]]
    # Each block is entered at one of its cells and left at another or the same: the cheapest choice, block by block.
    best = np.full((count, 4), np.inf)
    entry = np.zeros((count, 4), dtype=np.int64)
    source = np.zeros((count, 4), dtype=np.int64)
    price = np.empty((count, 4))
    for k in range(count):
        top = 2 * (chain[k] // width - 1) - odd_row
        left = 2 * (chain[k] % width - 1) - odd_column
        mask = blocks[chain[k] // width, chain[k] % width]
        entered = np.full(4, np.inf)
        came_from = np.zeros(4, dtype=np.int64)
        for b in range(4):
            price[k, b] = np.inf
            if mask & (1 << b):
                here = cost[top + (b >> 1), left + (b & 1)]
                price[k, b] = fee if here == np.inf else here
                if k == 0 and top + (b >> 1) == first[0] and left + (b & 1) == first[1]:
                    entered[b] = 0.0
        if k:
            dr = chain[k] // width - chain[k - 1] // width
            dc = chain[k] % width - chain[k - 1] % width
            for a in range(4):
                if best[k - 1, a] == np.inf:
                    continue
                for b in range(4):
                    i = 2 * dr + (b >> 1) - (a >> 1)
                    j = 2 * dc + (b & 1) - (a & 1)
                    if price[k, b] == np.inf or abs(i) > 1 or abs(j) > 1:
                        continue
                    length = 1.4142135623730951 if i and j else 1.0
                    total = best[k - 1, a] + 0.5 * length * (price[k - 1, a] + price[k, b])
                    if total < entered[b]:
                        entered[b], came_from[b] = total, a
        for a in range(4):
            if entered[a] == np.inf:
                continue
            for b in range(4):
                if price[k, b] == np.inf:
                    continue
                length = 0.0
                if a != b:
                    length = 1.4142135623730951 if a + b == 3 else 1.0
                total = entered[a] + 0.5 * length * (price[k, a] + price[k, b])
                if total < best[k, b]:
                    best[k, b], entry[k, b], source[k, b] = total, a, came_from[a]
    top = 2 * (end // width - 1) - odd_row
    left = 2 * (end % width - 1) - odd_column
    cells = np.empty((2 * count, 2), dtype=np.int64)
    b = (last[0] - top) * 2 + last[1] - left
    n = 0
    for k in range(count - 1, -1, -1):
        top = 2 * (chain[k] // width - 1) - odd_row
        left = 2 * (chain[k] % width - 1) - odd_column
        a = entry[k, b]
        cells[n, 0], cells[n, 1] = top + (b >> 1), left + (b & 1)
        n += 1
        if a != b:
            cells[n, 0], cells[n, 1] = top + (a >> 1), left + (a & 1)
            n += 1
        b = source[k, b]
    return cells[:n][::-1].copy()
