"""Exact label search for strategy selection: a multiple-choice knapsack with Lagrangian bounds.

Each class contributes one of its *options* (a set of its strategies that may stand together, fulfilling the class or
only serving others). Resources couple the classes; a dependency is one more resource, of capacity 0, that a provider
fills (negative cost) and those who require it, and the class's own desired utility, draw from. Classes are taken one
after the other; of the partial selections (*labels*) that use the same or more of everything and lose the same or more,
one is kept. A label whose loss, with the rest relaxed by multipliers λ on the resources, exceeds that of a selection
already known is cut.

All values are whole numbers, so the optimum is exact in every criterion. See Kellerer, Pferschy, Pisinger: *Knapsack
Problems* (2004), chapter 11, for the knapsack with multiple choices.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from app.attention.class_options import ClassOptions, Option, list_options
from app.attention.integer_program import Infeasible, IntegerProgram, ProgramSolution

_SMALL = 400
"""Number of combinations of options below which the multipliers cost more than they save."""
_BEAM = 12
_SWEEPS = 3
_MOST_LABELS = 20_000

Floats = NDArray[np.float64]
_Node = tuple["Option", "_Node | None"]
_Label = tuple[int, int, _Node | None]
"""(use of the first resource, loss, the options taken)"""


def solve_search(
    instance: IntegerProgram,
    deadline: float,
    *,
    choice: ClassOptions | None = None,
    most_labels: int = _MOST_LABELS,
    firm: bool = False,
) -> ProgramSolution | None:
    """The lexicographic optimum of ``instance``, or the best found until ``deadline`` (of ``time.perf_counter``).

    ``choice``: the options of ``instance``, if they are listed already. ``most_labels`` are kept at a time. A short,
    narrow search goes on beyond the deadline, so that there is something to keep then, unless ``firm``. It is the only
    one where several graded resources are contended for: few labels dominate others there.

    None if the structure is not for this search (a class with very many independent strategies), or where nothing was
    found in time. Raises Infeasible if the security desires cannot all be met.
    """
    if instance.impossible:
        raise Infeasible
    choice = choice or list_options(instance, deadline if firm else math.inf)
    if choice is None:
        return None
    if not choice.groups:
        return ProgramSolution((), instance.omega_criterion(choice.best), True)
    most_steps = math.inf if choice.graded <= 1 else 0
    combinations_ = 1
    for group in choice.groups:
        combinations_ *= len(group)
    known: tuple[int, _Node | None] | None = None
    multipliers = [0] * len(choice.capacities)
    if combinations_ <= _SMALL:
        # Takes milliseconds; but on a computer that is suspended meanwhile even that can be too long.
        most_steps, deadline = math.inf, math.inf
    elif choice.capacities:
        multipliers = _multipliers(choice, instance.omega_unit)
        choice, multipliers = _ordered(choice, multipliers)
        known, _, _ = _search(choice, multipliers, None, _BEAM, deadline if firm else math.inf)
    found, cut, finished = _search(
        choice, multipliers, known=known and known[0], width=most_labels, deadline=deadline, most_steps=most_steps
    )
    result = found or known
    if firm and not finished and time.perf_counter() > deadline:
        return None
    if result is None:
        if finished and cut is None:
            raise Infeasible
        return None
    loss, node = result
    least = loss if cut is None and finished else min(loss, _relaxed(choice, multipliers) if cut is None else cut)
    chosen: list[int] = []
    while node is not None:
        option, node = node
        chosen += option.strategies
    return ProgramSolution(tuple(sorted(chosen)), instance.omega_criterion(choice.best - least), least == loss)


def _search(
    choice: ClassOptions,
    multipliers: Sequence[int],
    known: int | None,
    width: int,
    deadline: float,
    most_steps: float = math.inf,
) -> tuple[tuple[int, _Node | None] | None, int | None, bool]:
    """The least loss, not above ``known``, keeping at most ``width`` labels a step.

    Returns the best label (loss, options) or None; the least bound among labels dropped for want of width (None: none
    dropped); and whether the end was reached before the deadline and within ``most_steps`` labels looked at.
    """
    groups, capacities = choice.groups, choice.capacities
    if not capacities:
        node: _Node | None = None
        for group in groups:
            node = (group[0], node)
        return (0, node), None, True
    future_low, future_high, relaxed = _futures(choice, multipliers)
    first, others = multipliers[0], multipliers[1:]
    cut: int | None = None
    front: dict[tuple[int, ...], list[_Label]] = {(0,) * (len(capacities) - 1): [(0, 0, None)]}
    for step, group in enumerate(groups):
        limits = [c - low for c, low in zip(capacities, future_low[step + 1], strict=True)]
        floors = [c - high for c, high in zip(capacities, future_high[step + 1], strict=True)]
        limit, floor = limits[0], floors[0]
        rest = list(zip(limits[1:], floors[1:], strict=True))
        ahead = relaxed[step + 1]
        following: dict[tuple[int, ...], list[_Label]] = {}
        for key, labels in front.items():
            for option in group:
                most_steps -= 1 + len(labels)
                if most_steps < 0 or time.perf_counter() > deadline:
                    return None, cut, False
                fits = True
                fresh_key = []
                for used, cost, (most, least) in zip(key, option.costs[1:], rest, strict=True):
                    total = used + cost
                    if total > most:
                        fits = False
                        break
                    fresh_key.append(total if total > least else least)
                if not fits:
                    continue
                bucket = following.setdefault(tuple(fresh_key), [])
                cost, loss = option.costs[0], option.loss
                if known is None:
                    slack = None
                else:
                    slack = known - ahead - sum(m * u for m, u in zip(others, fresh_key, strict=True))
                for used, lost, node in labels:
                    total = used + cost
                    if total > limit:
                        break
                    if total < floor:
                        total = floor
                    sum_ = lost + loss
                    if slack is not None and sum_ + first * total > slack:
                        continue
                    bucket.append((total, sum_, (option, node)))
        front = {key: _undominated(labels) for key, labels in following.items() if labels}
        if sum(map(len, front.values())) > width:
            front, dropped = _narrow(front, multipliers, ahead, width)
            cut = dropped if cut is None else min(cut, dropped)
    ends = [label for labels in front.values() for label in labels]
    if not ends:
        return None, cut, True
    end = min(ends, key=itemgetter(1))
    return (end[1], end[2]), cut, True


def _futures(choice: ClassOptions, multipliers: Sequence[int]) -> tuple[list[list[int]], list[list[int]], list[int]]:
    """For each step, over the classes from there on: the least and most use of each resource, and the relaxed loss."""
    size, steps = len(choice.capacities), len(choice.groups)
    low = [[0] * size for _ in range(steps + 1)]
    high = [[0] * size for _ in range(steps + 1)]
    relaxed = [0] * (steps + 1)
    priced = any(multipliers)
    relaxed[steps] = -sum(m * c for m, c in zip(multipliers, choice.capacities, strict=True))
    for step in range(steps - 1, -1, -1):
        group = choice.groups[step]
        columns = list(zip(*(option.costs for option in group), strict=True))
        low[step] = [total + min(column) for total, column in zip(low[step + 1], columns, strict=True)]
        high[step] = [total + max(column) for total, column in zip(high[step + 1], columns, strict=True)]
        if priced:
            least = min(
                option.loss + sum(m * c for m, c in zip(multipliers, option.costs, strict=True) if c)
                for option in group
            )
        else:
            least = min(option.loss for option in group)
        relaxed[step] = relaxed[step + 1] + least
    return low, high, relaxed


def _undominated(labels: list[_Label]) -> list[_Label]:
    """Of labels that use the same of all other resources: those of which no other uses and loses no more."""
    labels.sort(key=itemgetter(0, 1))
    kept = labels[:1]
    least = kept[0][1]
    for label in labels:
        if label[1] < least:
            kept.append(label)
            least = label[1]
    return kept


def _narrow(
    front: dict[tuple[int, ...], list[_Label]], multipliers: Sequence[int], ahead: int, width: int
) -> tuple[dict[tuple[int, ...], list[_Label]], int]:
    """The ``width`` labels of least bound, and the least bound among the others."""
    first, others = multipliers[0], multipliers[1:]
    bounds: list[tuple[int, tuple[int, ...], int]] = []
    for key, labels in front.items():
        base = sum(m * u for m, u in zip(others, key, strict=True) if u)
        bounds += [(label[1] + first * label[0] + base, key, index) for index, label in enumerate(labels)]
    bounds.sort()
    narrow: dict[tuple[int, ...], list[_Label]] = {}
    for _, key, index in bounds[:width]:
        narrow.setdefault(key, []).append(front[key][index])
    for labels in narrow.values():
        labels.sort(key=itemgetter(0))
    return narrow, bounds[width][0] + ahead


def _relaxed(choice: ClassOptions, multipliers: Sequence[int]) -> int:
    """The Lagrangian bound: no selection loses less."""
    bound = -sum(m * c for m, c in zip(multipliers, choice.capacities, strict=True))
    for group in choice.groups:
        bound += min(o.loss + sum(m * c for m, c in zip(multipliers, o.costs, strict=True)) for o in group)
    return bound


def _multipliers(choice: ClassOptions, unit: int) -> list[int]:
    """Multipliers near those of the greatest Lagrangian bound, found one resource at a time by bisection on its slack.

    Any multipliers ≥ 0 give a valid bound; better ones only cut more. In Ω per unit of the resource meanwhile.
    """
    widest = max(len(group) for group in choice.groups)
    size = len(choice.capacities)
    losses = np.full((len(choice.groups), widest), np.inf)
    costs = np.zeros((size, len(choice.groups), widest))
    for row, group in enumerate(choice.groups):
        for column, option in enumerate(group):
            losses[row, column] = option.loss / unit
            costs[:, row, column] = option.costs
    rows = np.arange(len(choice.groups))
    found = np.zeros(size)
    for sweep in range(_SWEEPS):
        for j in range(size):
            mine = costs[j]
            others = losses + np.tensordot(found, costs, axes=1) - found[j] * mine

            def excess(
                at: float, others: Floats = others, mine: Floats = mine, capacity: int = choice.capacities[j]
            ) -> float:
                """Use beyond capacity when every class takes its best option at this multiplier."""
                best = np.argmin(others + at * mine, axis=1)
                return float(mine[rows, best].sum()) - capacity

            if excess(0.0) <= 0:
                found[j] = 0.0
                continue
            low, high = 0.0, max(2 * found[j], 1e-6)
            while high < 1e9 and excess(high) > 0:
                low, high = high, high * 8
            for _ in range(10 + 4 * sweep):
                middle = (low + high) / 2
                if excess(middle) > 0:
                    low = middle
                else:
                    high = middle
            found[j] = high
    return [int(m * 2**40) * unit >> 40 for m in found]


def _ordered(choice: ClassOptions, multipliers: Sequence[int]) -> tuple[ClassOptions, list[int]]:
    """Order resources by the number of classes that use them (the first counts exactly), and classes so that labels
    stay few.

    Classes that share a resource with few users follow each other, so that the rest of the resource soon needs no
    distinction; then the others, the least decided last.
    """
    size = len(choice.capacities)
    users = [sum(any(option.costs[j] for option in group) for group in choice.groups) for j in range(size)]
    dims = sorted(range(size), key=lambda j: -users[j])

    def place(group: list[Option]) -> tuple[int, int]:
        reduced = sorted(o.loss + sum(m * c for m, c in zip(multipliers, o.costs, strict=True)) for o in group)
        regret = reduced[1] - reduced[0] if len(reduced) > 1 else 1 << 4096
        rarest = max((n for n, j in enumerate(dims) if n and any(o.costs[j] for o in group)), default=0)
        return (-rarest, -regret)

    groups = [
        [Option(o.loss, tuple([o.costs[j] for j in dims]), o.strategies, o.serves) for o in group]
        for group in sorted(choice.groups, key=place)
    ]
    ordered = replace(choice, groups=groups, capacities=tuple(choice.capacities[j] for j in dims))
    return ordered, [multipliers[j] for j in dims]
