"""The table of strategies in whole numbers, with its mutual exclusions: computed once for all problems over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from app.attention.desires import GRAIN
from app.attention.strategies import Strategy

_FEW = 64
"""Strategies of a class that share no filter are compared pair by pair up to this number."""


_MOST = 2**53


class InvalidProblem(ValueError):
    """The problem contradicts itself: a cost of an unknown resource, a negative amount, a value finer than a
    thousandth."""


def thousandths(value: float, *what: str) -> int:
    """``value`` as a whole number of thousandths; raises InvalidProblem if it is none, or negative. ``what`` it is, in
    pieces: they are put together only for the complaint."""
    scaled = value * GRAIN
    if not 0 <= scaled < _MOST:
        raise InvalidProblem(f"{''.join(what)} must be at least 0 and at most {_MOST // GRAIN:,}, not {value!r}")
    whole = round(scaled)
    if abs(scaled - whole) > 1e-4:
        raise InvalidProblem(f"{''.join(what)} must have at most three decimals, not {value!r}")
    return whole


@dataclass(frozen=True, slots=True)
class Members:
    """The strategies of one class, by index in the table: ``all`` in its order; ``cliques`` those that set one filter,
    two or more, of which at most one can be selected; ``exclusive``: they all exclude each other."""

    all: tuple[int, ...]
    cliques: tuple[tuple[int, ...], ...]
    exclusive: bool


@dataclass(frozen=True, slots=True)
class PreparedTable:
    """A table in whole thousandths: by index of its strategy ``utility``, ``requires`` (what is needed of a class) and
    ``costs`` (of a resource); ``members`` by class, in table order; ``totals`` of each resource, all costs together."""

    strategies: tuple[Strategy, ...]
    utility: tuple[int, ...]
    requires: tuple[dict[str, int], ...]
    costs: tuple[dict[str, int], ...]
    members: dict[str, Members]
    totals: dict[str, int]


def prepare(strategies: tuple[Strategy, ...]) -> PreparedTable:
    """The table of ``strategies``, in time linear in its size. Raises InvalidProblem."""
    by_class: dict[str, list[int]] = {}
    totals: dict[str, int] = {}
    costs = []
    for index, s in enumerate(strategies):
        by_class.setdefault(s.cls, []).append(index)
        mine = {name: thousandths(cost, s.name, ": cost of ", name) for name, cost in s.costs.items()}
        for name, cost in mine.items():
            totals[name] = totals.get(name, 0) + cost
        costs.append(mine)
    return PreparedTable(
        strategies,
        tuple(thousandths(s.utility, s.name, ": utility") for s in strategies),
        requires=tuple(
            {c: thousandths(need, s.name, ": requires ", c) for c, need in s.requires.items() if need > 0}
            for s in strategies
        ),
        costs=tuple(costs),
        members={cls: _members(strategies, indices) for cls, indices in by_class.items()},
        totals=totals,
    )


def _members(strategies: Sequence[Strategy], indices: Sequence[int]) -> Members:
    by_filter: dict[str, list[int]] = {}
    for index in indices:
        for name in strategies[index].filters:
            by_filter.setdefault(name, []).append(index)
    cliques = tuple(dict.fromkeys(tuple(group) for group in by_filter.values() if len(group) > 1))
    return Members(tuple(indices), cliques, all_exclude(indices, cliques))


def all_exclude(group: Sequence[int], cliques: Sequence[Sequence[int]]) -> bool:
    """Whether every two of ``group`` share a clique. Over ``_FEW`` that are not in one clique give False, unchecked."""
    if len(group) < 2 or any(len(clique) == len(group) for clique in cliques):
        return True
    if len(group) > _FEW:
        return False
    pairs = {pair for clique in cliques for pair in combinations(clique, 2)}
    return len(pairs) == len(group) * (len(group) - 1) // 2
