"""Options of each class: the sets of its strategies that may be selected together."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter, le

from app.attention.integer_program import Infeasible, IntegerProgram
from app.attention.prepared import MOST_SETS, sets_of


@dataclass(frozen=True, slots=True)
class Option:
    """``loss``: by how much its value falls short of the best of its class; ``costs`` per resource, then per
    dependency; ``serves``: its class counts as fulfilled."""

    loss: int
    costs: tuple[int, ...]
    strategies: tuple[int, ...]
    serves: bool


_Stated = tuple[int, tuple[int, ...], tuple[int, ...], bool]
"""(value, costs, strategies, whether it serves)"""


@dataclass(frozen=True, slots=True)
class ClassOptions:
    """The options of every class, and the capacities that couple them. ``graded`` counts the resources for which
    several classes contend in more amounts than all or nothing. ``best`` is the sum of the classes' best values.
    ``constraints`` are the places of the capacities among all resources and dependencies; ``idle`` has the options that
    a class would have without its desire, where these were asked for."""

    groups: list[list[Option]]
    capacities: tuple[int, ...]
    best: int
    graded: int
    constraints: tuple[int, ...]
    idle: list[list[Option]]


def list_options(
    instance: IntegerProgram, deadline: float = math.inf, *, with_idle: bool = False
) -> ClassOptions | None:
    """Options per class, without those that another of the class dominates, and without resources that never bind.

    None if there are too many, or the deadline came first.
    """
    needed = sorted(instance.needed)
    width = len(instance.capacities)
    column = {k: width + position for position, k in enumerate(needed)}
    groups: list[list[_Stated]] = []
    idle: list[list[_Stated]] = []
    for k in range(len(instance.members)):
        sets = (
            None
            if time.perf_counter() > deadline
            else sets_of(instance.members[k], instance.cliques[k], instance.exclusive[k])
        )
        if sets is None:
            return None
        serving, others = _options(instance, k, sets, column)
        options = serving if k in instance.security else serving + others
        if not options:
            raise Infeasible
        groups.append(_efficient(options))
        if with_idle:
            idle.append(_efficient(others))
    capacities = (*instance.capacities, *(0 for _ in needed))
    # A class whose desire is gone may no longer fill what others require.
    either = [group + others for group, others in zip(groups, idle, strict=True)] if with_idle else groups
    binding = [
        j
        for j, capacity in enumerate(capacities)
        if sum(max(option[1][j] for option in group) for group in either) > capacity
    ]
    resources = [j for j in binding if j < len(instance.capacities)]
    best = sum(group[0][0] for group in groups)
    graded = len(resources)
    if graded > 1:
        graded = sum(_is_graded([[option[1][j] for option in group] for group in groups]) for j in resources)
    return ClassOptions(
        _narrowed(groups, binding),
        tuple(capacities[j] for j in binding),
        best,
        graded,
        constraints=tuple(binding),
        idle=_narrowed(idle, binding),
    )


def _options(
    instance: IntegerProgram, k: int, sets: Sequence[tuple[int, ...]], column: Mapping[int, int]
) -> tuple[list[_Stated], list[_Stated]]:
    """The options of class k that fulfil it, and the others. ``column`` places the dependencies on classes."""
    wanted = instance.desired.get(k)
    serving: list[_Stated] = []
    others: list[_Stated] = []
    for chosen in sets:
        costs = [0] * (len(instance.capacities) + len(column))
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
            serving.append((value + gain, tuple(filled), chosen, True))
        if not chosen or k in column:
            others.append((value, tuple(costs), chosen, False))
    return serving, others


def _narrowed(groups: list[list[_Stated]], binding: list[int]) -> list[list[Option]]:
    """The options of each group with the costs ``binding`` alone."""
    return [
        [Option(group[0][0] - v, tuple([c[j] for j in binding]), chosen, serves) for v, c, chosen, serves in group]
        for group in groups
    ]


def _is_graded(costs: list[list[int]]) -> bool:
    """Whether several classes contend for a resource (``costs`` by class and option), and not for all or nothing."""
    users = [set(group) for group in costs if any(group)]
    return len(users) > 1 and len(set().union(*users) - {0}) > 1


def _efficient(options: list[_Stated]) -> list[_Stated]:
    """Options (value, costs, strategies) by falling value, without those that another dominates.

    With several costs, each is compared with a bounded number of better ones: an option too many is harmless.
    """
    options.sort(key=itemgetter(0), reverse=True)
    kept: list[_Stated] = []
    for option in options:
        costs = option[1]
        # With one cost, the option kept last is the cheapest so far.
        for better in kept[-1:] if len(costs) == 1 else kept[:MOST_SETS]:
            if better[1] == costs or all(map(le, better[1], costs)):
                break
        else:
            kept.append(option)
    return kept
