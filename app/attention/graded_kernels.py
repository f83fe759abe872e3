"""The compiled inner loop of :mod:`app.attention.graded`: depth first over classes, the last of them by a table."""

from __future__ import annotations

import numpy as np

from app.base.compiled import kernel


@kernel(
    "Tuple((int64, int64, int64))(int64[::1], int64[:, ::1], int64[:, ::1], int64[:, ::1], int64[::1], int64[::1],"
    " int64[::1], int64[::1], int64[:, ::1], int64, int64)"
)
def search(offsets, options, levels, tail, cells, grid, prices, limits, found, unit, most):  # type: ignore[no-untyped-def]
    """All selections of least reduced loss within ``limits``: (that loss, their number, steps taken).

    ``prices`` has an entry for each of R constraints. A row of ``options`` has Q reduced losses, the objective's last,
    then R costs; options of class i are ``offsets[i]`` to ``offsets[i + 1]``, by rising objective. ``tail`` has such
    rows for all combinations of the classes after the last of ``offsets``, in the order of ``cells``: of ``grid`` (p,
    its origin, width and count; r, the same; q) p and r are the constraints that place a row in a cell, q the one
    whose cost orders a cell. ``levels`` has, for each class and the tail, the least and then the greatest that what
    follows may use. ``limits`` has the greatest reduced losses (Q) and the capacities (R).
    What is better is so by ``unit`` of reduced loss at least.

    Each row of ``found`` takes a selection: its options, then the row of the tail. With one row in it, what is only as
    good is not looked for. Their number exceeds the rows of ``found`` where there were more; steps exceed ``most``
    where the search was not finished.
    """
    size = offsets.shape[0] - 1
    width = prices.shape[0]
    losses = options.shape[1] - width
    goal = losses - 1
    rows = found.shape[0]
    known = limits[:losses].copy()
    room = np.empty((size + 1, width), np.int64)
    room[0] = limits[losses:]
    lost = np.zeros((size + 1, losses), np.int64)
    place = np.empty(size + 1, np.int64)
    place[0] = offsets[0]
    p, origin_p, width_p, count_p = grid[0], grid[1], grid[2], grid[3]
    r, origin_r, width_r, count_r = grid[4], grid[5], grid[6], grid[7]
    q = grid[8]
    far = np.int64(1) << 60
    several = rows > 1
    best = known[goal]
    count = 0
    steps = 0
    depth = 0
    while depth >= 0:
        if steps > most:
            break
        if depth == size:
            # What stays unused costs its price: so a row must use nearly all there is of each constraint.
            slack = known[goal] - lost[depth, goal]
            most_p, most_q, most_r = room[depth, p], room[depth, q], room[depth, r]
            least_p = most_p - slack // prices[p] - 1 if prices[p] > 0 else -far
            least_q = most_q - slack // prices[q] - 1 if prices[q] > 0 else -far
            least_r = most_r - slack // prices[r] - 1 if prices[r] > 0 else -far
            first_p = max(0, (least_p - origin_p) // width_p) if least_p > origin_p else 0
            last_p = min(count_p - 1, (most_p - origin_p) // width_p) if most_p >= origin_p else -1
            first_r = max(0, (least_r - origin_r) // width_r) if least_r > origin_r else 0
            last_r = min(count_r - 1, (most_r - origin_r) // width_r) if most_r >= origin_r else -1
            for cell_p in range(first_p, last_p + 1):
                for cell_r in range(first_r, last_r + 1):
                    cell = cell_p * count_r + cell_r
                    row, end = cells[cell], cells[cell + 1]
                    high = end
                    while row < high:
                        middle = (row + high) // 2
                        if tail[middle, losses + q] < least_q:
                            row = middle + 1
                        else:
                            high = middle
                    while row < end and tail[row, losses + q] <= most_q:
                        steps += 1
                        total = lost[depth, goal] + tail[row, goal]
                        fits = total <= known[goal]
                        j = 0
                        while fits and j < width:
                            left = room[depth, j] - tail[row, losses + j]
                            fits = left >= 0
                            total += prices[j] * left
                            j += 1
                        if fits and total <= known[goal]:
                            if count == 0 or total < best:
                                count, best = 0, total
                            if count < rows:
                                for i in range(size):
                                    found[count, i] = place[i] - 1
                                found[count, size] = row
                            count += 1
                            # Once there is no room for another, only better ones are looked for.
                            known[goal] = total if several and count <= rows else total - unit
                        row += 1
            depth -= 1
            continue
        option = place[depth]
        if option >= offsets[depth + 1]:
            depth -= 1
            continue
        place[depth] = option + 1
        steps += 1
        total = lost[depth, goal] + options[option, goal]
        if total > known[goal]:
            depth -= 1
            continue
        lost[depth + 1, goal] = total
        fits = True
        for k in range(goal):
            sum_ = lost[depth, k] + options[option, k]
            if sum_ > known[k]:
                fits = False
                break
            lost[depth + 1, k] = sum_
        if not fits:
            continue
        for j in range(width):
            left = room[depth, j] - options[option, losses + j]
            if left < levels[depth + 1, j]:
                fits = False
                break
            room[depth + 1, j] = left
            if left > levels[depth + 1, width + j]:
                total += prices[j] * (left - levels[depth + 1, width + j])
        if not fits or total > known[goal]:
            continue
        depth += 1
        if depth < size:
            place[depth] = offsets[depth]
    return best, count, steps
