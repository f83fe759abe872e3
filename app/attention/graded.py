"""Exact search where several graded resources are contended for: one criterion after the other, each to its proof.

The problem is that of :mod:`app.attention.search`: one option per class, constraints that couple the classes. Where
several of them bind, few partial selections dominate others. So the classes are searched depth first, all of it
compiled (:mod:`app.attention.graded_kernels`), with three bounds: prices of the constraints, from the linear
relaxation, which add to an option's loss what it uses; room that what follows cannot use and must be paid for; and a
table of all combinations of the last classes, from which only rows are read that use nearly all there is left.

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
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.attention.class_options import ClassOptions, Option
from app.attention.graded_kernels import optimum
from app.attention.integer_program import Criterion, Infeasible, IntegerProgram, ProgramSolution

_STEPS_PER_S: Final = 3e7
_MOST_STEPS: Final = 150_000_000
"""Steps of the search, which takes 5 to 10 ns for one; beyond the limit (about a second) CP-SAT is tried."""

Whole = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Columns:
    """Options as the compiled search takes them, one after the other.

    ``losses`` (criteria × options): by how much one falls short of the best of its group in a criterion, in units of
    ``grain``, which has the greatest common divisor of each row; ``most`` is the first criterion's sum of the best.
    ``costs`` (constraints × options), multiples of the constraint's ``unit``; ``strategies`` (options × the most that
    one has) in rising order, then -1. ``starts`` is the first option of each group, and the end.
    """

    losses: Whole
    grain: Whole
    most: int
    costs: Whole
    unit: Whole
    strategies: Whole
    starts: Whole

    @classmethod
    def of(cls, criteria: Sequence[Criterion], groups: Sequence[tuple[int, Sequence[Option]]], width: int) -> Columns:
        """Of the options of each class (its number k, its options), with ``width`` costs each."""
        options = [option for _, group in groups for option in group]
        starts = np.cumsum([0, *(len(group) for _, group in groups)], dtype=np.int64)
        losses = np.zeros((len(criteria), len(options)), dtype=np.int64)
        grain = np.ones(len(criteria), dtype=np.int64)
        most = 0
        for number, criterion in enumerate(criteria):
            fulfil, serve, pay = criterion.fulfil, criterion.serve, criterion.pay
            row: list[int] = []
            for k, group in groups:
                values = [
                    (fulfil.get(k, 0) + sum([serve[s] for s in option.strategies]) if option.serves else 0)
                    - sum([pay[s] for s in option.strategies])
                    for option in group
                ]
                best = max(values)
                most += best if number == 0 else 0
                row += [best - value for value in values]
            grain[number] = math.gcd(*row) or 1
            losses[number] = [loss // int(grain[number]) for loss in row]
        longest = max((len(option.strategies) for option in options), default=0)
        strategies = np.full((len(options), max(longest, 1)), -1, dtype=np.int64)
        for row_, option in zip(strategies, options, strict=True):
            row_[: len(option.strategies)] = option.strategies
        costs = np.array([option.costs for option in options], dtype=np.int64).reshape(len(options), width).T
        unit = np.maximum(np.gcd.reduce(costs, axis=1, initial=0), 1)
        return cls(losses, grain, most, np.ascontiguousarray(costs), unit, strategies, starts)

    def usable(self, capacities: Whole) -> Whole:
        """What can be used of ``capacities``: the rest would only loosen the linear relaxation."""
        return capacities - capacities % self.unit


def solve_graded(
    instance: IntegerProgram, choice: ClassOptions, deadline: float, known: ProgramSolution | None = None
) -> ProgramSolution | None:
    """The lexicographic optimum; or, at ``deadline`` (of ``time.perf_counter``) or after a bounded number of steps,
    the best of what was found and ``known``, with the bound that was reached.

    None where there is nothing. Raises Infeasible.
    """
    columns = Columns.of(instance.criteria[:-1], list(enumerate(choice.groups)), len(choice.capacities))
    status, loss, _, chosen = optimum(
        first=columns.starts[:-1],
        last=columns.starts[1:],
        losses=columns.losses,
        costs=columns.costs,
        strategies=columns.strategies,
        capacities=columns.usable(np.array(choice.capacities, dtype=np.int64)),
        most=steps_until(deadline),
    )
    if status == 1:
        raise Infeasible
    bound = columns.most - int(loss) * int(columns.grain[0])
    if len(chosen) == 0 or chosen[0] >= 0:
        taken = columns.strategies[chosen]
        return ProgramSolution(tuple(sorted(taken[taken >= 0].tolist())), bound, status == 0)
    return None if known is None else ProgramSolution(known.chosen, min(bound, known.bound), False)


def steps_until(deadline: float, most: float = math.inf) -> int:
    """Steps of the search that end before ``deadline`` (of ``time.perf_counter``), at most ``most``."""
    return int(min(most, _MOST_STEPS, max(deadline - time.perf_counter(), 0.0) * _STEPS_PER_S))
