"""Exact search where several graded resources are contended for: one criterion after the other, each to its proof.

The problem is that of :mod:`app.attention.search`: one option per class, constraints that couple the classes. Where
several of them bind, few partial selections dominate others. So the classes are searched depth first, by a compiled
loop (:mod:`app.attention.graded_kernels`), with three bounds: prices of the constraints, from the linear relaxation,
which add to an option's loss what it uses; room that what follows cannot use and must be paid for; and a table of all
combinations of the last classes, from which only rows are read that use nearly all there is left.

The least loss is guessed, from the bound of the relaxation upwards: a guess that is too low is soon refuted, and one
that is not gives the optimum. The criteria before become constraints of the next one, with their optimum as capacity:
so ties cost little. All whole numbers, but for the prices, which may be any number from 0 on.

See Kellerer, Pferschy, Pisinger: *Knapsack Problems* (2004), chapters 9 and 11.
"""

# mypy: allow-untyped-calls
from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from app.attention.class_options import ClassOptions, Option
from app.attention.graded_kernels import search
from app.attention.integer_program import Criterion, Infeasible, IntegerProgram, ProgramSolution, table_order

_BITS: Final = 58
"""Of the greatest number of the search: sums of a few still fit into 64."""
_LEAST_BITS: Final = 8
_MOST_BITS: Final = 32
"""Bits of a price behind the point: fewer than the least are too coarse to bound anything."""
_STEPS_PER_S: Final = 3e7
_MOST_STEPS: Final = 150_000_000
"""Steps of the search, which takes 5 to 10 ns for one; beyond the limit (about a second) CP-SAT is tried."""
_ROWS: Final = ((500, 2_000_000), (16_000, _MOST_STEPS))
"""The most rows of the table of the last classes, and the steps after which it is given the next number of rows."""
_TIES: Final = 256
"""Selections that are equal in a criterion, among which the best is looked for one by one."""

Whole = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class _Level:
    """What is left to decide: options by column, those of a class beside each other, constraints by row of ``costs``.

    ``option`` is a column's place in the list of all options, ``cls`` its class. ``reduced`` has a row for each
    criterion decided already: the reduced losses, in which no selection may exceed ``limits``.
    """

    option: Whole
    cls: Whole
    costs: Whole
    capacities: Whole
    reduced: Whole
    limits: Whole

    def within(self) -> NDArray[np.bool_]:
        """By column, whether it may be part of a selection within the limits."""
        fits: NDArray[np.bool_] = np.all(self.reduced <= self.limits[:, None], axis=0)
        return fits

    def only(self, kept: NDArray[np.bool_]) -> _Level:
        return replace(
            self,
            option=self.option[kept],
            cls=self.cls[kept],
            costs=self.costs[:, kept],
            reduced=self.reduced[:, kept],
        )


@dataclass(frozen=True, slots=True)
class _Optimum:
    """Of one criterion: its ``loss``; selections of that loss (places in the list of all options), ``whole`` if these
    are all; None ``chosen``: unknown, but for the loss being no less."""

    loss: int
    chosen: tuple[tuple[int, ...], ...] | None = None
    whole: bool = False


def solve_graded(
    instance: IntegerProgram, choice: ClassOptions, deadline: float, known: ProgramSolution | None = None
) -> ProgramSolution | None:
    """The lexicographic optimum; or, at ``deadline`` (of ``time.perf_counter``) or after a bounded number of steps,
    the best of what was found and ``known``, with the bound that was reached.

    None where there is nothing. Raises Infeasible.
    """
    options = [option for group in choice.groups for option in group]
    level = _Level(
        np.arange(len(options)),
        np.array([k for k, group in enumerate(choice.groups) for _ in group], dtype=np.int64),
        np.array([option.costs for option in options], dtype=np.int64).T.reshape(len(choice.capacities), -1),
        np.array(choice.capacities, dtype=np.int64),
        reduced=np.zeros((0, len(options)), dtype=np.int64),
        limits=np.zeros(0, dtype=np.int64),
    )
    best: tuple[int, ...] | None = None
    bound = 0
    steps = _MOST_STEPS
    for number, criterion in enumerate((*instance.criteria[:-1], *table_order(len(instance.cls)))):
        losses, grain, most = _losses(criterion, choice)
        mine = losses[level.option]
        if number and not mine.any():
            continue
        stage = _Stage(level, mine, deadline, steps)
        optimum = stage.solve(None if best is None else int(losses[list(best)].sum()), _TIES if number else 1)
        steps -= stage.steps
        if number == 0:
            bound = most - optimum.loss * grain
        if optimum.chosen is None:
            break
        # Of those found equal so far, the best in all criteria.
        best = min(optimum.chosen, key=lambda places: sum(options[place].loss for place in places))
        if optimum.whole:
            return ProgramSolution(_strategies(options, best), bound, True)
        level = stage.following(optimum.loss)
    else:
        # Selections that are equal in all criteria are of the same strategies.
        return None if best is None else ProgramSolution(_strategies(options, best), bound, True)
    if best is not None:
        return ProgramSolution(_strategies(options, best), bound, False)
    return None if known is None else ProgramSolution(known.chosen, min(bound, known.bound), False)


def _strategies(options: Sequence[Option], places: Sequence[int]) -> tuple[int, ...]:
    return tuple(sorted(s for place in places for s in options[place].strategies))


def _losses(criterion: Criterion, choice: ClassOptions) -> tuple[Whole, int, int]:
    """By option, how much it falls short in ``criterion`` of the best of its class; the unit of that; and the sum of
    the best."""
    values = [
        [
            (criterion.fulfil.get(k, 0) + sum(criterion.serve[s] for s in option.strategies) if option.serves else 0)
            - sum(criterion.pay[s] for s in option.strategies)
            for option in group
        ]
        for k, group in enumerate(choice.groups)
    ]
    losses = [max(group) - value for group in values for value in group]
    grain = math.gcd(*losses) or 1
    return np.array([loss // grain for loss in losses], dtype=np.int64), grain, sum(max(group) for group in values)


class _Stage:
    """The least sum of ``losses`` (by column of ``level``), and what has it. ``steps`` counts those taken."""

    def __init__(self, level: _Level, losses: Whole, deadline: float, most_steps: int) -> None:
        self.steps = 0
        self._level = level
        self._losses = losses
        self._deadline = deadline
        self._most_steps = most_steps
        starts = _starts(level.cls)
        floats = _prices(level, losses, starts)
        # Each sum of reduced losses is below all losses and all that is used at these prices.
        widest = float(np.maximum.reduceat(losses + floats @ np.abs(level.costs), starts).sum())
        bits = min(_BITS - math.ceil(math.log2(widest + 2)), _MOST_BITS)
        self._unit = 1 << max(bits, 0)
        self._prices = np.array(np.maximum(np.rint(floats * self._unit), 0), dtype=np.int64)
        self._coarse = bits < _LEAST_BITS
        priced = losses * self._unit + self._prices @ level.costs
        least = np.minimum.reduceat(priced, starts)
        self._reduced = priced - np.repeat(least, np.diff([*starts, len(losses)]))
        #: Ω's relaxation: no selection loses less, in units of a price.
        self._base = int(least.sum()) - int(self._prices @ level.capacities)

    def solve(self, enough: int | None, ties: int) -> _Optimum:
        """``enough`` is the loss of a selection that is known. At most ``ties`` selections are looked for."""
        level, spans = self._level, _starts(self._level.cls)
        least = max(-(-self._base // self._unit), 0)
        if self._coarse:
            return _Optimum(least)
        ranges = np.maximum.reduceat(self._losses, spans)
        worst = int(ranges.sum())
        most = worst if enough is None else enough
        # A class's choice is undecided by about a twentieth of what it is about.
        step = max(1, int(np.median(ranges)) // 20)
        guess = min(least + step - 1, most)
        while True:
            limit = guess * self._unit - self._base
            kept = (self._reduced <= limit) & level.within()
            found = self._within(limit, kept, ties)
            if found is None:
                return _Optimum(least)
            if found.chosen is not None:
                return found
            if guess >= most:
                raise Infeasible
            least = guess + 1
            guess, step = min(guess + step, most), 2 * step

    def following(self, loss: int) -> _Level:
        """What is left to decide once this criterion's ``loss`` is a constraint."""
        level = self._level
        limit = loss * self._unit - self._base
        following = replace(
            level,
            costs=np.vstack([level.costs, self._losses]),
            capacities=np.append(level.capacities, loss),
            reduced=np.vstack([level.reduced, self._reduced]),
            limits=np.append(level.limits, limit),
        )
        return following.only(following.within())

    def _within(self, limit: int, kept: NDArray[np.bool_], ties: int) -> _Optimum | None:
        """What is found with reduced losses up to ``limit``, in the columns ``kept``; None if there was no time."""
        level = self._level.only(kept)
        classes = int(self._level.cls.max(initial=-1)) + 1
        if len(np.unique(level.cls)) < len(np.unique(self._level.cls)) or not classes:
            return _Optimum(0)
        for rows, most in _ROWS:
            left_s = self._deadline - time.perf_counter()
            allowed = int(min(most, self._most_steps - self.steps, max(left_s, 0) * _STEPS_PER_S))
            tree = _Tree(level, self._reduced[kept], limit, self._prices, rows)
            found = np.zeros((ties, tree.depth + 1), dtype=np.int64)
            total, count, steps = tree.search(found, self._unit, allowed)
            self.steps += steps
            if steps <= allowed:
                break
        else:
            return None
        if not count:
            return _Optimum(0)
        loss = (total + self._base) // self._unit
        return _Optimum(loss, tuple(tree.chosen(row) for row in found[:count]), ties > 1 and count <= ties)


def _starts(cls: Whole) -> Whole:
    """The first column of each class."""
    return np.flatnonzero(np.r_[True, cls[1:] != cls[:-1]])


def _prices(level: _Level, losses: Whole, starts: Whole) -> NDArray[np.float64]:
    """The constraints' prices in the linear relaxation, in loss per unit. Raises Infeasible."""
    scale = np.maximum(np.abs(level.costs).max(axis=1, initial=1), 1).astype(float)
    one_each = np.zeros((len(starts), len(losses)))
    one_each[np.repeat(np.arange(len(starts)), np.diff([*starts, len(losses)])), np.arange(len(losses))] = 1
    answer = linprog(
        losses.astype(float),
        A_ub=level.costs / scale[:, None],
        b_ub=level.capacities / scale,
        A_eq=one_each,
        b_eq=np.ones(len(starts)),
        method="highs-ds",
    )
    if answer.status == 2:
        raise Infeasible
    if answer.status != 0:
        return np.zeros(len(scale))
    return np.asarray(np.maximum(-answer.ineqlin.marginals, 0) / scale)


class _Tree:
    """The arrays of the compiled search: classes by falling regret, the last of them in a table of ``most_rows``."""

    def __init__(self, level: _Level, reduced: Whole, limit: int, prices: Whole, most_rows: int) -> None:
        self._limits = np.concatenate([level.limits, [limit], level.capacities])
        self._prices = prices
        goal = len(level.limits)
        losses = goal + 1
        starts = _starts(level.cls)
        sizes = np.diff([*starts, len(level.cls)])
        # Where a class's second best loses much, the first is nearly always taken: such classes come first.
        regret = [
            np.partition(reduced[a : a + n], 1)[1] if n > 1 else np.iinfo(np.int64).max
            for a, n in zip(starts, sizes, strict=True)
        ]
        rank = np.empty(len(starts), dtype=np.int64)
        rank[np.argsort(regret, kind="stable")[::-1]] = np.arange(len(starts))
        place = np.repeat(rank, sizes)
        order = np.lexsort((reduced, place))
        options = np.vstack([level.reduced, reduced, level.costs])[:, order].T
        offsets = np.searchsorted(place[order], np.arange(len(starts) + 1))
        self._option = level.option[order]
        table = np.zeros((1, options.shape[1]), dtype=np.int64)
        combined = np.zeros((1, 0), dtype=np.int64)
        depth = len(starts)
        while depth:
            first, end = offsets[depth - 1], offsets[depth]
            rows = (options[first:end, None] + table).reshape(-1, table.shape[1])
            within = (rows[:, :losses] <= self._limits[:losses]).all(axis=1)
            if within.sum() > most_rows:
                break
            ahead = np.repeat(np.arange(first, end), len(table))[:, None]
            combined = np.hstack([ahead, np.tile(combined, (end - first, 1))])[within]
            table = rows[within]
            depth -= 1
        self.depth = depth
        self._offsets = np.ascontiguousarray(offsets[: depth + 1])
        self._options = np.ascontiguousarray(options)
        self._place_rows(table, combined, losses, limit)
        uses = [
            (column.min(axis=0), column.max(axis=0))
            for column in (options[offsets[i] : offsets[i + 1], losses:] for i in range(depth))
        ]
        levels = np.zeros((depth + 1, 2 * len(prices)), dtype=np.int64)
        if len(table):
            levels[depth] = np.concatenate([table[:, losses:].min(axis=0), table[:, losses:].max(axis=0)])
        for i in range(depth - 1, -1, -1):
            levels[i] = levels[i + 1] + np.concatenate(uses[i])
        self._levels = levels

    def _place_rows(self, table: Whole, combined: Whole, losses: int, limit: int) -> None:
        """Put the table's rows into cells by the two constraints that tell most of them apart, each ordered by a
        third."""
        costs = table[:, losses:]
        apart = costs.std(axis=0) * self._prices if len(costs) > 1 else np.zeros(len(self._prices))
        widest = np.argsort(-apart, kind="stable")
        p, q, r = (int(widest[min(i, len(widest) - 1)]) for i in range(3))
        (origin_p, width_p, count_p), (origin_r, width_r, count_r) = (
            self._cells_along(
                costs[:, j] if len(costs) else np.zeros(1, np.int64), limit, int(self._prices[j]), at_most
            )
            for j, at_most in ((p, 64), (r, 64 if r not in (p, q) else 1))
        )
        cell = (costs[:, p] - origin_p) // width_p * count_r + (costs[:, r] - origin_r) // width_r
        order = np.lexsort((costs[:, q], cell))
        self._table = np.ascontiguousarray(table[order])
        self._combined = combined[order]
        self._cells = np.searchsorted(cell[order], np.arange(count_p * count_r + 1))
        self._grid = np.array([p, origin_p, width_p, count_p, r, origin_r, width_r, count_r, q], dtype=np.int64)

    @staticmethod
    def _cells_along(costs: Whole, limit: int, price: int, at_most: int) -> tuple[int, int, int]:
        """The first cost, the width and the number of cells."""
        origin, extent = int(costs.min()), int(np.ptp(costs))
        slack = max(limit // price, 1) if price else extent
        width = max(slack // 2, extent // at_most, 0) + 1
        return origin, width, extent // width + 1

    def search(self, found: Whole, unit: int, most: int) -> tuple[int, int, int]:
        """The least reduced loss, the number of selections that have it, and the steps taken; see the kernel."""
        if not len(self._table):
            return 0, 0, 0
        total, count, steps = search(
            offsets=self._offsets,
            options=self._options,
            levels=self._levels,
            tail=self._table,
            cells=self._cells,
            grid=self._grid,
            prices=self._prices,
            limits=self._limits,
            found=found,
            unit=unit,
            most=most,
        )
        return int(total), int(count), int(steps)

    def chosen(self, row: Whole) -> tuple[int, ...]:
        """The places, in the list of all options, of what the search found."""
        columns = [*row[:-1], *self._combined[row[-1]]]
        return tuple(int(self._option[column]) for column in columns)
