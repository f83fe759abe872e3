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

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from app.attention.instance import Answer, Infeasible, Instance

_MOST_OPTIONS = 64
"""A class with more sets of strategies that may stand together is left to CP-SAT."""
_SMALL = 400
"""Below so many combinations of options the multipliers cost more than they save."""
_BEAM = 12
_SWEEPS = 3
_MOST_LABELS = 20_000

Floats = NDArray[np.float64]
_Node = tuple["_Option", "_Node | None"]
_Label = tuple[int, int, _Node | None]
"""(use of the first resource, loss, the options taken)"""


@dataclass(frozen=True, slots=True)
class _Option:
    """``loss``: by how much its value falls short of the best of its class; ``costs`` per resource, then per
    dependency."""

    loss: int
    costs: tuple[int, ...]
    strategies: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Choice:
    """The classes' options and what couples them. ``best`` is the sum of the classes' best values."""

    groups: list[list[_Option]]
    capacities: tuple[int, ...]
    best: int


def solve_search(instance: Instance, deadline: float, *, most_labels: int = _MOST_LABELS) -> Answer | None:
    """The lexicographic optimum of ``instance``, or the best found until ``deadline`` (of ``time.perf_counter``).

    None if the structure is not for this search (a class with very many independent strategies), or where even the
    narrow search that heeds no deadline found nothing. Raises Infeasible if the security desires cannot all be met.
    """
    if instance.impossible:
        raise Infeasible
    choice = _choice(instance)
    if choice is None:
        return None
    if not choice.groups:
        return Answer((), instance.omega_criterion(choice.best), True)
    combinations_ = 1
    for group in choice.groups:
        combinations_ *= len(group)
    known: tuple[int, _Node | None] | None = None
    multipliers = [0] * len(choice.capacities)
    if combinations_ <= _SMALL:
        # Over in milliseconds; but on a computer that stands still meanwhile even that can be too long.
        deadline = float("inf")
    elif choice.capacities:
        multipliers = _multipliers(choice, instance.omega_unit)
        choice, multipliers = _ordered(choice, multipliers)
        # Short, and never cut off: there is always something to keep when the time is over.
        known, _, _ = _search(choice, multipliers, None, _BEAM, float("inf"))
    found, cut, finished = _search(choice, multipliers, known and known[0], most_labels, deadline)
    result = found or known
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
    return Answer(tuple(sorted(chosen)), instance.omega_criterion(choice.best - least), least == loss)


def _choice(instance: Instance) -> _Choice | None:
    """Options per class, without those that another of the class dominates, and without resources that never bind."""
    needed = sorted(instance.needed)
    width = len(instance.capacities)
    column = {k: width + position for position, k in enumerate(needed)}
    groups: list[list[tuple[int, tuple[int, ...], tuple[int, ...]]]] = []
    for k, members in enumerate(instance.members):
        sets = _sets(instance, members)
        if sets is None:
            return None
        wanted = instance.desired.get(k)
        options = []
        for chosen in sets:
            costs = [0] * (width + len(needed))
            value = 0
            produced = 0
            for s in chosen:
                value -= instance.pay[s]
                produced += instance.utility[s]
                for j, cost in enumerate(instance.costs[s]):
                    costs[j] += cost
                for other, amount in instance.requires[s].items():
                    costs[column[other]] += amount
            if k in column:
                costs[column[k]] -= produced
            if wanted is not None and produced >= wanted:
                filled = list(costs)
                if k in column:
                    filled[column[k]] += wanted
                gain = instance.fulfil[k] + sum(instance.serve[s] for s in chosen)
                options.append((value + gain, tuple(filled), chosen))
            if k not in instance.security and (not chosen or k in column):
                options.append((value, tuple(costs), chosen))
        if not options:
            raise Infeasible
        options.sort(key=itemgetter(0), reverse=True)
        kept: list[tuple[int, tuple[int, ...], tuple[int, ...]]] = []
        for option in options:
            costs_ = option[1]
            for better in kept:
                if all(a <= b for a, b in zip(better[1], costs_, strict=True)):
                    break
            else:
                kept.append(option)
        groups.append(kept)
    capacities = (*instance.capacities, *(0 for _ in needed))
    binding = [
        j
        for j, capacity in enumerate(capacities)
        if sum(max(option[1][j] for option in group) for group in groups) > capacity
    ]
    best = sum(group[0][0] for group in groups)
    pruned = [
        [_Option(group[0][0] - v, tuple(c[j] for j in binding), chosen) for v, c, chosen in group] for group in groups
    ]
    return _Choice(pruned, tuple(capacities[j] for j in binding), best)


def _sets(instance: Instance, members: tuple[int, ...]) -> list[tuple[int, ...]] | None:
    """The sets of a class's strategies that exclude each other in no pair; None if there are too many."""
    sets: list[tuple[int, ...]] = [(), *((s,) for s in members)]
    if all(len(instance.conflicts[s]) == len(members) - 1 for s in members):
        return sets
    for size in range(2, len(members) + 1):
        fresh = [
            chosen
            for chosen in combinations(members, size)
            if not any(one in instance.conflicts[other] for one, other in combinations(chosen, 2))
        ]
        sets += fresh
        if len(sets) > _MOST_OPTIONS:
            return None
        if not fresh:
            break
    return sets


def _search(
    choice: _Choice, multipliers: Sequence[int], known: int | None, width: int, deadline: float
) -> tuple[tuple[int, _Node | None] | None, int | None, bool]:
    """The least loss, not above ``known``, keeping at most ``width`` labels a step.

    Returns the best label (loss, options) or None; the least bound among labels dropped for want of width (None: none
    dropped); and whether the end was reached before the deadline.
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
                if time.perf_counter() > deadline:
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


def _futures(choice: _Choice, multipliers: Sequence[int]) -> tuple[list[list[int]], list[list[int]], list[int]]:
    """For each step, over the classes from there on: the least and most use of each resource, and the relaxed loss."""
    size, steps = len(choice.capacities), len(choice.groups)
    low = [[0] * size for _ in range(steps + 1)]
    high = [[0] * size for _ in range(steps + 1)]
    relaxed = [0] * (steps + 1)
    relaxed[steps] = -sum(m * c for m, c in zip(multipliers, choice.capacities, strict=True))
    for step in range(steps - 1, -1, -1):
        group = choice.groups[step]
        columns = list(zip(*(option.costs for option in group), strict=True))
        low[step] = [total + min(column) for total, column in zip(low[step + 1], columns, strict=True)]
        high[step] = [total + max(column) for total, column in zip(high[step + 1], columns, strict=True)]
        relaxed[step] = relaxed[step + 1] + min(
            option.loss + sum(m * c for m, c in zip(multipliers, option.costs, strict=True) if c) for option in group
        )
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


def _relaxed(choice: _Choice, multipliers: Sequence[int]) -> int:
    """The Lagrangian bound: no selection loses less."""
    bound = -sum(m * c for m, c in zip(multipliers, choice.capacities, strict=True))
    for group in choice.groups:
        bound += min(o.loss + sum(m * c for m, c in zip(multipliers, o.costs, strict=True)) for o in group)
    return bound


def _multipliers(choice: _Choice, unit: int) -> list[int]:
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


def _ordered(choice: _Choice, multipliers: Sequence[int]) -> tuple[_Choice, list[int]]:
    """Resources by how many classes use them, the first counting in full; classes so that labels stay few.

    Classes that share a resource of few users stand together, so that what it has left is soon no longer told apart;
    then the others, the least decided last.
    """
    size = len(choice.capacities)
    users = [sum(any(option.costs[j] for option in group) for group in choice.groups) for j in range(size)]
    dims = sorted(range(size), key=lambda j: -users[j])

    def place(group: list[_Option]) -> tuple[int, int]:
        reduced = sorted(o.loss + sum(m * c for m, c in zip(multipliers, o.costs, strict=True)) for o in group)
        regret = reduced[1] - reduced[0] if len(reduced) > 1 else 1 << 4096
        rarest = max((n for n, j in enumerate(dims) if n and any(o.costs[j] for o in group)), default=0)
        return (-rarest, -regret)

    groups = [
        [_Option(o.loss, tuple(o.costs[j] for j in dims), o.strategies) for o in group]
        for group in sorted(choice.groups, key=place)
    ]
    ordered = _Choice(groups, tuple(choice.capacities[j] for j in dims), choice.best)
    return ordered, [multipliers[j] for j in dims]
