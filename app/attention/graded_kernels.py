"""The compiled search of :mod:`app.attention.graded`: its inner loop (depth first over classes, the last of them by a
table), and what is around it up to all criteria."""

# mypy: allow-untyped-calls

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


@kernel(
    "Tuple((float64[::1], int64))(int64[::1], float64[::1], float64[:, ::1], float64[::1], int64)",
)
def prices(starts, losses, costs, room, most):  # type: ignore[no-untyped-def]
    """The constraints' prices in the linear relaxation, in loss per unit, and whether there are (0), no selection fits
    (1), or neither is known after ``most`` pivots or for want of precision (2: any prices ≥ 0 bound the loss, these
    less well).

    Columns ``starts[k]`` to ``starts[k + 1]`` are the options of class k, of which the relaxation takes one in all. A
    row of ``costs`` has what each uses of a constraint; ``room`` is what there is. Losses are at least 0.

    The dual simplex method with one key column a class (generalized upper bounds: G. B. Dantzig, R. M. Van Slyke, J.
    Comput. Syst. Sci. 1, 1967): the basis to invert has a row for each constraint only. The best options of all are
    where it begins, which is optimal but for what does not fit.
    """
    classes, width, size = starts.shape[0] - 1, room.shape[0], losses.shape[0]
    left = room.copy()
    key = np.empty(classes, np.int64)
    for k in range(classes):
        best = starts[k]
        for c in range(starts[k], starts[k + 1]):
            if losses[c] < losses[best]:
                best = c
        key[k] = best
        for j in range(width):
            left[j] -= costs[j, best]
    # A basic column of each row: its class (-1: what is left unused of a constraint), and the column.
    held = np.full(width, -1, np.int64)
    basic = np.empty(width, np.int64)
    inverse = np.zeros((width, width))
    for j in range(width):
        inverse[j, j] = 1.0
        basic[j] = j
    price = np.zeros(width)
    priced = losses.copy()
    along = np.empty(size)
    values = np.empty(width)
    column = np.empty(width)
    for _ in range(most):
        worst, row, swapped = -1e-9, -1, -1
        for i in range(width):
            total = 0.0
            for j in range(width):
                total += inverse[i, j] * left[j]
            values[i] = total
            if total < worst:
                worst, row = total, i
        for i in range(width):
            if held[i] >= 0:
                total, largest = 1.0, i
                for other in range(width):
                    if held[other] == held[i]:
                        total -= values[other]
                        if values[other] > values[largest]:
                            largest = other
                if total < worst:
                    worst, row, swapped = total, largest, largest
        if row < 0:
            return price, 0
        if swapped >= 0:
            # The key column is to leave: another basic column of its class takes its part.
            k = held[row]
            old, new = key[k], basic[row]
            for j in range(width):
                total = 0.0
                for other in range(width):
                    if held[other] == k:
                        total += inverse[other, j]
                left[j] += costs[j, old] - costs[j, new]
                column[j] = -total
            for j in range(width):
                inverse[row, j] = column[j]
            key[k], basic[row] = new, old
        along[:] = 0.0
        for j in range(width):
            weight = inverse[row, j]
            if weight != 0.0:
                for c in range(size):
                    along[c] += weight * costs[j, c]
        ratio, steepest, entering, of = np.inf, 0.0, -1, -1
        for k in range(classes):
            mine, base = along[key[k]], priced[key[k]]
            for c in range(starts[k], starts[k + 1]):
                slope = along[c] - mine
                if slope < -1e-9:
                    here = max(priced[c] - base, 0.0) / -slope
                    if here < ratio - 1e-12 or (here <= ratio + 1e-12 and slope < steepest):
                        ratio, steepest, entering, of = min(here, ratio), slope, c, k
        for j in range(width):
            slope = inverse[row, j]
            if slope < -1e-9:
                here = max(price[j], 0.0) / -slope
                if here < ratio - 1e-12 or (here <= ratio + 1e-12 and slope < steepest):
                    ratio, steepest, entering, of = min(here, ratio), slope, j, -1
        if entering < 0:
            # Farkas: at these weights even the least that all classes take is more than there is. Checked again, for
            # what was updated many times is not exact.
            short = size_ = 0.0
            for j in range(width):
                weight = max(inverse[row, j], 0.0)
                short -= weight * room[j]
                size_ += weight * abs(room[j])
            for k in range(classes):
                least = np.inf
                for c in range(starts[k], starts[k + 1]):
                    total = 0.0
                    for j in range(width):
                        total += max(inverse[row, j], 0.0) * costs[j, c]
                    least = min(least, total)
                short += least
                size_ += abs(least)
            return price, 1 if short > 1e-9 * size_ else 2
        for j in range(width):
            price[j] += ratio * inverse[row, j]
        for c in range(size):
            priced[c] += ratio * along[c]
        for i in range(width):
            if of < 0:
                column[i] = inverse[i, entering]
            else:
                total = 0.0
                for j in range(width):
                    total += inverse[i, j] * (costs[j, entering] - costs[j, key[of]])
                column[i] = total
        if abs(column[row]) < 1e-12:
            return price, 2
        for j in range(width):
            inverse[row, j] /= column[row]
        for i in range(width):
            if i != row and column[i] != 0.0:
                for j in range(width):
                    inverse[i, j] -= column[i] * inverse[row, j]
        held[row], basic[row] = of, entering
    return price, 2


@kernel(
    "Tuple((int64, int64, int64))(int64[::1], int64[:, ::1], int64[::1], int64[::1], int64, int64, int64, int64,"
    " int64[:, ::1])",
)
def tree(starts, rows, weights, limits, goal, unit, most_rows, most, found):  # type: ignore[no-untyped-def]
    """As :func:`search`, with the arrays it needs made here: of columns ``starts[k]`` to ``starts[k + 1]`` one for
    each class k. ``rows`` has for each column what ``options`` has there, the objective's reduced loss at ``goal``;
    ``weights`` are the prices; the last classes are in a table of at most ``most_rows``. A row of ``found`` takes a
    selection: the column of each class.
    """
    classes, width, losses = starts.shape[0] - 1, weights.shape[0], goal + 1
    breadth = losses + width
    # Where a class's second best loses much, the first is nearly always taken: such classes come first.
    regret = np.empty(classes, np.int64)
    kept = np.empty(rows.shape[0], np.int64)
    ends = np.empty(classes, np.int64)
    for k in range(classes):
        end = starts[k]
        for c in range(starts[k], starts[k + 1]):
            fits = True
            for q in range(losses):
                if rows[c, q] > limits[q]:
                    fits = False
            if fits:
                place = end
                while place > starts[k] and rows[kept[place - 1], goal] > rows[c, goal]:
                    kept[place] = kept[place - 1]
                    place -= 1
                kept[place] = c
                end += 1
        if end == starts[k]:
            return 0, 0, 0
        ends[k] = end
        regret[k] = rows[kept[starts[k] + 1], goal] if end - starts[k] > 1 else np.int64(1) << 60
    order = np.argsort(regret)[::-1]
    offsets = np.zeros(classes + 1, np.int64)
    for i in range(classes):
        offsets[i + 1] = offsets[i] + ends[order[i]] - starts[order[i]]
    options = np.empty((offsets[classes], breadth), np.int64)
    source = np.empty(offsets[classes], np.int64)
    for i in range(classes):
        for n in range(offsets[i + 1] - offsets[i]):
            c = kept[starts[order[i]] + n]
            source[offsets[i] + n] = c
            for j in range(breadth):
                options[offsets[i] + n, j] = rows[c, j]
    # The table: each layer adds a class, of whose option and of which row before it keeps the number.
    table = np.zeros((most_rows, breadth), np.int64)
    other = np.empty((most_rows, breadth), np.int64)
    taken = np.empty((classes, most_rows), np.int32)
    before = np.empty((classes, most_rows), np.int32)
    count, depth = 1, classes
    while depth:
        made = 0
        for c in range(offsets[depth - 1], offsets[depth]):
            for row in range(count):
                fits = True
                for q in range(losses):
                    if table[row, q] + options[c, q] > limits[q]:
                        fits = False
                if fits:
                    if made == most_rows:
                        made += 1
                        break
                    for j in range(breadth):
                        other[made, j] = table[row, j] + options[c, j]
                    taken[depth - 1, made], before[depth - 1, made] = c, row
                    made += 1
            if made > most_rows:
                break
        if made > most_rows:
            break
        if not made:
            return 0, 0, 0
        depth -= 1
        count = made
        table, other = other, table
    levels = np.zeros((depth + 1, 2 * width), np.int64)
    apart = np.zeros(width)
    for j in range(width):
        mean = spread = 0.0
        least = most_ = table[0, losses + j]
        for row in range(count):
            cost = table[row, losses + j]
            mean += cost
            spread += float(cost) * cost
            least, most_ = min(least, cost), max(most_, cost)
        mean /= count
        apart[j] = np.sqrt(max(spread / count - mean * mean, 0.0)) * weights[j]
        levels[depth, j], levels[depth, width + j] = least, most_
        for i in range(depth - 1, -1, -1):
            least = most_ = options[offsets[i], losses + j]
            for c in range(offsets[i], offsets[i + 1]):
                least, most_ = min(least, options[c, losses + j]), max(most_, options[c, losses + j])
            levels[i, j], levels[i, width + j] = levels[i + 1, j] + least, levels[i + 1, width + j] + most_
    # Rows in cells by two constraints, each cell ordered by a third: those that separate most of them.
    widest = np.argsort(-apart)
    grid = np.empty(9, np.int64)
    grid[0], grid[8], grid[4] = widest[0], widest[min(1, width - 1)], widest[min(2, width - 1)]
    for place in (0, 4):
        j = grid[place]
        extent = levels[depth, width + j] - levels[depth, j]
        slack = max(limits[goal] // weights[j], 1) if weights[j] else extent
        grid[place + 1] = levels[depth, j]
        grid[place + 2] = max(slack // 2, extent // 64) + 1
        grid[place + 3] = extent // grid[place + 2] + 1
    if width < 3:
        grid[6], grid[7] = levels[depth, width + grid[4]] - levels[depth, grid[4]] + 1, 1
    key = np.empty(count, np.int64)
    for row in range(count):
        p = (table[row, losses + grid[0]] - grid[1]) // grid[2]
        r = (table[row, losses + grid[4]] - grid[5]) // grid[6]
        key[row] = p * grid[7] + r
    q = grid[8]
    span = levels[depth, width + q] - levels[depth, q] + 1
    cells = np.zeros(grid[3] * grid[7] + 1, np.int64)
    for row in range(count):
        cells[key[row] + 1] += 1
        key[row] = key[row] * span + table[row, losses + q] - levels[depth, q]
    for n in range(1, cells.shape[0]):
        cells[n] += cells[n - 1]
    ranked = np.argsort(key)
    tail = np.empty((count, breadth), np.int64)
    for row in range(count):
        for j in range(breadth):
            tail[row, j] = table[ranked[row], j]
    selections = np.zeros((found.shape[0], depth + 1), np.int64)
    total, number, steps = search(
        offsets[: depth + 1], options, levels, tail, cells, grid, weights, limits, selections, unit, most
    )
    for n in range(min(number, found.shape[0])):
        for i in range(depth):
            found[n, order[i]] = source[selections[n, i]]
        row = ranked[selections[n, depth]]
        for i in range(depth, classes):
            found[n, order[i]] = source[taken[i, row]]
            row = before[i, row]
    return total, number, steps


@kernel(
    "Tuple((int64, int64, int64, int64, int64, int64[::1]))(int64[::1], int64[::1], int64[:, ::1], int64[::1],"
    " int64[:, ::1], int64[::1], int64, int64[:, ::1], int64)",
)
def level(starts, losses, costs, room, passed, limits, most_loss, found, most):  # type: ignore[no-untyped-def]
    """The least sum of ``losses``, not above ``most_loss``, over selections of one column for each class that ``room``
    has the ``costs`` of (a row for each constraint) and that exceed ``limits`` in no row of ``passed``.

    (0: found, 1: there is none, 2: not finished within ``most`` steps; the loss, or what it is no less than; the
    number of selections that have it, as many of them in ``found`` as it has rows; steps; the reduced loss of that
    loss; the reduced losses of the columns).
    """
    classes, width, size = starts.shape[0] - 1, room.shape[0], losses.shape[0]
    reduced = np.zeros(size, np.int64)
    # What is there beyond what all together can use has no price.
    capacity = room.copy()
    scale = np.ones(width)
    scaled = np.empty((width, size))
    for j in range(width):
        greatest = np.int64(0)
        for k in range(classes):
            most_ = costs[j, starts[k]]
            for c in range(starts[k], starts[k + 1]):
                most_ = max(most_, costs[j, c])
                scale[j] = max(scale[j], abs(costs[j, c]))
            greatest += most_
        capacity[j] = min(capacity[j], greatest)
        for c in range(size):
            scaled[j, c] = costs[j, c] / scale[j]
    top, worst = np.int64(1), np.int64(0)
    for k in range(classes):
        most_ = np.int64(0)
        for c in range(starts[k], starts[k + 1]):
            most_ = max(most_, losses[c])
        worst += most_
        top = max(top, most_)
    floats, status = prices(starts, losses / top, scaled, capacity / scale, 20 * (classes + width) + 100)
    if status == 1:
        return 1, 0, 0, 0, 0, reduced
    widest = 2.0
    for j in range(width):
        floats[j] = max(floats[j], 0.0) * top / scale[j]
    for k in range(classes):
        greatest_ = 0.0
        for c in range(starts[k], starts[k + 1]):
            sum_ = float(losses[c])
            for j in range(width):
                sum_ += floats[j] * abs(costs[j, c])
            greatest_ = max(greatest_, sum_)
        widest += greatest_
    bits = min(58 - int(np.ceil(np.log2(widest))), 32)
    unit = np.int64(1) << max(bits, 0)
    weights = np.empty(width, np.int64)
    base = np.int64(0)
    for j in range(width):
        weights[j] = np.int64(np.rint(floats[j] * unit))
        base -= weights[j] * capacity[j]
    for k in range(classes):
        least = np.int64(1) << 62
        for c in range(starts[k], starts[k + 1]):
            priced = losses[c] * unit
            for j in range(width):
                priced += weights[j] * costs[j, c]
            reduced[c] = priced
            least = min(least, priced)
        base += least
        for c in range(starts[k], starts[k + 1]):
            reduced[c] -= least
    least = max(-(-base // unit), np.int64(0))
    if bits < 8:
        return 2, least, 0, 0, 0, reduced
    goal = limits.shape[0]
    rows = np.empty((size, goal + 1 + width), np.int64)
    for c in range(size):
        for q in range(goal):
            rows[c, q] = passed[q, c]
        rows[c, goal] = reduced[c]
        for j in range(width):
            rows[c, goal + 1 + j] = costs[j, c]
    bounds = np.empty(goal + 1 + width, np.int64)
    for q in range(goal):
        bounds[q] = limits[q]
    for j in range(width):
        bounds[goal + 1 + j] = capacity[j]
    highest = min(worst, most_loss)
    # A class's choice is undecided by about a twentieth of what it is about.
    step = max(1, worst // (20 * max(classes, 1)))
    guess = min(least + step - 1, highest)
    steps = np.int64(0)
    while True:
        bounds[goal] = guess * unit - base
        finished = False
        number = total = np.int64(0)
        # Most searches are short: a table that takes longer to make than to do without comes later.
        for most_rows, allowed in ((64, 10_000), (500, 2_000_000), (16_000, most)):
            allowed = min(allowed, most - steps)
            total, number, taken = tree(starts, rows, weights, bounds, goal, unit, most_rows, allowed, found)
            steps += taken
            if taken <= allowed:
                finished = True
                break
        if not finished:
            return 2, least, 0, steps, 0, reduced
        if number:
            loss = (total + base) // unit
            return 0, loss, number, steps, loss * unit - base, reduced
        if guess >= highest:
            return 1, 0, 0, steps, 0, reduced
        least = guess + 1
        guess, step = min(guess + step, highest), 2 * step


@kernel("boolean(int64[::1], int64[::1], int64[::1], int64[:, ::1], int64[:, ::1], int64)")
def _better(fresh, chosen, alive, losses, strategies, number):  # type: ignore[no-untyped-def]
    """Whether the columns ``alive[fresh]`` are better than those ``chosen``, from criterion ``number`` on."""
    for criterion in range(number, losses.shape[0]):
        difference = np.int64(0)
        for k in range(fresh.shape[0]):
            difference += losses[criterion, alive[fresh[k]]] - losses[criterion, chosen[k]]
        if difference:
            return difference < 0
    earliest, ours = np.int64(1) << 60, False
    for k in range(fresh.shape[0]):
        mine, other = strategies[alive[fresh[k]]], strategies[chosen[k]]
        for n in range(mine.shape[0]):
            # Both are in rising order: the first place where they differ has the first strategy of one alone.
            if mine[n] != other[n]:
                if other[n] < 0 or 0 <= mine[n] < other[n]:
                    here, has = mine[n], True
                else:
                    here, has = other[n], False
                if here < earliest:
                    earliest, ours = here, has
                break
    return ours


@kernel(
    "Tuple((int64, int64, int64, int64[::1]))(int64[::1], int64[::1], int64[:, ::1], int64[:, ::1], int64[:, ::1],"
    " int64[::1], int64)",
)
def optimum(first, last, losses, costs, strategies, capacities, most):  # type: ignore[no-untyped-def]
    """The selection of one column for each class k, of ``first[k]`` to ``last[k]``, of least ``losses``: a row for each
    criterion, those before deciding first; then of the first strategy in which two differ, the one that has it.

    ``costs`` has a row for each constraint, ``capacities`` what there is; a row of ``strategies`` has those of a
    column in rising order, then -1.

    (0: proven, 1: there is none, 2: not proven within ``most`` steps; what the first loss is no less than; steps; the
    columns, -1 where none was found).
    """
    classes, width, criteria = first.shape[0], capacities.shape[0], losses.shape[0]
    chosen = np.full(classes, -1, np.int64)
    # A column is of use if what it takes is there beside the least that the others take.
    least = np.empty((width, classes), np.int64)
    for j in range(width):
        spare = capacities[j]
        for k in range(classes):
            least[j, k] = costs[j, first[k]]
            for c in range(first[k], last[k]):
                least[j, k] = min(least[j, k], costs[j, c])
            spare -= least[j, k]
        if spare < 0:
            return 1, 0, 0, chosen
        for k in range(classes):
            least[j, k] += spare
    alive = np.empty(losses.shape[1], np.int64)
    starts = np.zeros(classes + 1, np.int64)
    size = 0
    for k in range(classes):
        for c in range(first[k], last[k]):
            fits = True
            for j in range(width):
                if costs[j, c] > least[j, k]:
                    fits = False
            if fits:
                alive[size] = c
                size += 1
        if size == starts[k]:
            return 1, 0, 0, chosen
        starts[k + 1] = size
    room = capacities.copy()
    use = np.empty((width, size), np.int64)
    for j in range(width):
        for n in range(size):
            use[j, n] = costs[j, alive[n]]
    passed = np.empty((0, size), np.int64)
    limits = np.empty(0, np.int64)
    count = strategies.max() + 1
    bound = steps = np.int64(0)
    for number in range(criteria + (count + 29) // 30):
        mine = np.empty(size, np.int64)
        differ = number == 0
        if number < criteria:
            for n in range(size):
                mine[n] = losses[number, alive[n]]
        else:
            begin = 30 * (number - criteria)
            for k in range(classes):
                best = np.int64(0)
                for n in range(starts[k], starts[k + 1]):
                    mine[n] = 0
                    for s in strategies[alive[n]]:
                        if begin <= s < begin + 30:
                            mine[n] += np.int64(1) << (begin + 29 - s)
                    best = max(best, mine[n])
                for n in range(starts[k], starts[k + 1]):
                    mine[n] = best - mine[n]
        enough = np.int64(0)
        for k in range(classes):
            for n in range(starts[k], starts[k + 1]):
                differ = differ or mine[n] != mine[starts[k]]
                if alive[n] == chosen[k]:
                    enough += mine[n]
        if not differ:
            continue
        found = np.zeros((256 if number else 1, classes), np.int64)
        status, loss, equal, taken, limit, reduced = level(
            starts, mine, use, room, passed, limits, enough if number else np.int64(1) << 60, found, most - steps
        )
        steps += taken
        if number == 0:
            bound = loss
        if status:
            return status, bound, steps, chosen
        for row in range(min(equal, found.shape[0])):
            if row == 0 or _better(found[row], chosen, alive, losses, strategies, number + 1):
                for k in range(classes):
                    chosen[k] = alive[found[row, k]]
        if number and equal <= found.shape[0]:
            return 0, bound, steps, chosen
        # From here on, this criterion is a constraint.
        kept = 0
        place = np.empty(size, np.int64)
        begins = np.zeros(classes + 1, np.int64)
        for k in range(classes):
            for n in range(starts[k], starts[k + 1]):
                if reduced[n] <= limit:
                    place[kept] = n
                    kept += 1
            begins[k + 1] = kept
        grown = np.empty((room.shape[0] + 1, kept), np.int64)
        decided = np.empty((limits.shape[0] + 1, kept), np.int64)
        for i in range(kept):
            n = place[i]
            alive[i] = alive[n]
            for j in range(room.shape[0]):
                grown[j, i] = use[j, n]
            grown[room.shape[0], i] = mine[n]
            for q in range(limits.shape[0]):
                decided[q, i] = passed[q, n]
            decided[limits.shape[0], i] = reduced[n]
        room, limits = np.append(room, loss), np.append(limits, limit)
        use, passed, starts, size = grown, decided, begins, kept
    return 0, bound, steps, chosen
