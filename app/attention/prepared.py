"""The table of strategies in whole numbers, with its mutual exclusions: computed once for all problems over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from app.attention.desires import GRAIN
from app.attention.strategies import Strategy

_FEW = 64
"""Strategies of a class that share no filter are compared pair by pair up to this number."""


_SMALL = 64
"""Sets are listed for tables of at most this many strategies."""

MOST_SETS = 64
"""Of the strategies of a class, that are listed."""

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
class ClassSet:
    """A set of strategies of one class that may stand together, by index in the table. ``produced`` is their utility;
    ``costs`` in the table's ``columns``; ``order`` has a bit for each, the first of the table the highest."""

    strategies: tuple[int, ...]
    produced: int
    costs: tuple[int, ...]
    order: int


class ClassSets:
    """The sets of the strategies of each class that may stand together, listed when they are asked for: problems over
    large tables never do."""

    def __init__(self) -> None:
        self._listed: dict[str, tuple[ClassSet, ...] | None] = {}

    def of(self, table: PreparedTable, cls: str) -> tuple[ClassSet, ...] | None:
        """All of ``cls``, the empty one first; None if there are too many. Two threads may both list them: the same."""
        if cls not in self._listed:
            members = table.members[cls]
            listed = sets_of(members.all, members.cliques, members.exclusive)
            self._listed[cls] = None if listed is None else tuple([_class_set(table, chosen) for chosen in listed])
        return self._listed[cls]


@dataclass(frozen=True, slots=True)
class PreparedTable:
    """A table in whole thousandths: by index of its strategy ``utility``, ``requires`` (what is needed of a class) and
    ``costs`` (of a resource); ``members`` by class, in table order; ``totals`` of each resource, all costs together.

    ``needed`` are the classes that some strategy requires, ``required`` those that strategies of a class require,
    ``produced`` all utilities together. ``sets`` are of each class's strategies; None where the table is large.
    ``columns`` places resources (by name) and needed classes (by name, in a tuple of one) in their costs.
    """

    strategies: tuple[Strategy, ...]
    utility: tuple[int, ...]
    requires: tuple[dict[str, int], ...]
    costs: tuple[dict[str, int], ...]
    members: dict[str, Members]
    totals: dict[str, int]
    needed: tuple[str, ...]
    required: dict[str, tuple[str, ...]]
    produced: int
    columns: dict[str | tuple[str], int]
    sets: ClassSets | None


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
    utility = tuple(thousandths(s.utility, s.name, ": utility") for s in strategies)
    requires = tuple(
        {c: thousandths(need, s.name, ": requires ", c) for c, need in s.requires.items() if need > 0}
        for s in strategies
    )
    members = {cls: _members(strategies, indices) for cls, indices in by_class.items()}
    needed = tuple(sorted({c for needs in requires for c in needs}))
    columns: dict[str | tuple[str], int] = {name: place for place, name in enumerate(totals)}
    columns |= {(cls,): len(totals) + place for place, cls in enumerate(needed)}
    required = {
        cls: found
        for cls, indices in by_class.items()
        if (found := tuple(dict.fromkeys(c for index in indices for c in requires[index])))
    }

    return PreparedTable(
        strategies,
        utility,
        requires=requires,
        costs=tuple(costs),
        members=members,
        totals=totals,
        needed=needed,
        required=required,
        produced=sum(utility),
        columns=columns,
        sets=ClassSets() if len(strategies) <= _SMALL else None,
    )


def _class_set(table: PreparedTable, chosen: tuple[int, ...]) -> ClassSet:
    columns = table.columns
    row = [0] * len(columns)
    for index in chosen:
        for name, cost in table.costs[index].items():
            row[columns[name]] += cost
        for c, need in table.requires[index].items():
            row[columns[c,]] += need
    produced = sum(table.utility[index] for index in chosen)
    if chosen and (own := columns.get((table.strategies[chosen[0]].cls,))) is not None:
        row[own] -= produced
    order = sum(1 << (len(table.strategies) - 1 - index) for index in chosen)
    return ClassSet(chosen, produced, tuple(row), order)


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


def sets_of(members: Sequence[int], cliques: Sequence[Sequence[int]], exclusive: bool) -> list[tuple[int, ...]] | None:
    """The sets of ``members`` of which no two share a clique, smaller ones first; None if there are over
    ``MOST_SETS`` and ``members`` are not ``exclusive``."""
    sets: list[tuple[int, ...]] = [(), *((s,) for s in members)]
    if exclusive:
        return sets
    if len(sets) > MOST_SETS:
        return None
    apart = {pair for clique in cliques for pair in combinations(clique, 2)}
    for size in range(2, len(members) + 1):
        fresh = [
            chosen
            for chosen in combinations(members, size)
            if not any(pair in apart for pair in combinations(chosen, 2))
        ]
        sets += fresh
        if len(sets) > MOST_SETS:
            return None
        if not fresh:
            break
    return sets
