"""An upper bound of the utility that the strategies of a class produce together, with unlimited resources."""

from __future__ import annotations

from collections.abc import Sequence

from app.attention.desires import GRAIN
from app.attention.prepared import PreparedTable

_MOST_STEPS = 5000
"""Limit of the search where a class's strategies exclude each other in many ways; beyond it the best found counts."""


def best_utility(table: PreparedTable, cls: str, inhibited: frozenset[str] = frozenset()) -> float:
    """The greatest utility of strategies of ``cls`` that exclude each other in no pair and require no class
    ``inhibited``. 0 without such strategies. Takes time linear in the class, and a bounded number of steps beyond
    it."""
    members = table.members.get(cls)
    if members is None:
        return 0.0
    able = [index for index in members.all if inhibited.isdisjoint(table.requires[index])]
    if members.exclusive:
        return max((table.utility[index] for index in able), default=0) / GRAIN
    # Strategies that set one filter exclude each other: of each such group at most one is selected.
    groups = _groups(table, able, members.cliques)
    return _most(table, groups) / GRAIN


def _groups(table: PreparedTable, able: Sequence[int], cliques: Sequence[Sequence[int]]) -> list[list[int]]:
    """``able`` parted into groups, in each of which all exclude each other; each by falling utility."""
    left = set(able)
    groups: list[list[int]] = []
    for clique in sorted(cliques, key=len, reverse=True):
        group = [index for index in clique if index in left]
        left -= set(group)
        if group:
            groups.append(group)
    groups += [[index] for index in sorted(left)]
    return [sorted(group, key=lambda index: -table.utility[index]) for group in groups]


def _most(table: PreparedTable, groups: Sequence[Sequence[int]]) -> int:
    """The greatest sum of utilities of at most one strategy per group, no two of which set a filter in common."""
    filters = {index: frozenset(table.strategies[index].filters) for group in groups for index in group}
    ahead = [0] * (len(groups) + 1)
    for place in range(len(groups) - 1, -1, -1):
        ahead[place] = ahead[place + 1] + table.utility[groups[place][0]]
    best, steps = 0, 0
    # Depth first, the strategies of greatest utility first: (groups decided, utility so far, filters taken).
    todo: list[tuple[int, int, frozenset[str]]] = [(0, 0, frozenset())]
    while todo and steps < _MOST_STEPS:
        place, total, taken = todo.pop()
        steps += 1
        best = max(best, total)
        if place == len(groups) or total + ahead[place] <= best:
            continue
        todo.append((place + 1, total, taken))
        for index in reversed(groups[place]):
            if taken.isdisjoint(filters[index]):
                todo.append((place + 1, total + table.utility[index], taken | filters[index]))
                steps += 1
    return best
