"""Depth-first branch and bound for small selection problems, on the table as it was prepared.

Each class contributes one of its *sets* of strategies that may stand together, fulfilling the class or only serving
others; a dependency is one more resource, of capacity 0, that its class fills. The value of a set is one whole number:
the six criteria of :mod:`app.attention.integer_program` in mixed radix. What the table alone decides (sets, costs,
dependencies) was computed with it, so that a problem costs only its own numbers: a tenth of a millisecond is less than
the general way takes to state it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import add, itemgetter, le, sub
from typing import Final

from app.attention.integer_program import Infeasible
from app.attention.prepared import ClassSets, PreparedTable, thousandths
from app.attention.problem import SelectionProblem, spare_resource, thrift_resource

MOST_COMBINATIONS: Final = 5_000
"""Of the sets of all classes; beyond it the bounds of other searches pay."""
MOST_SETS_TOGETHER: Final = 40_000
"""Of the sets that were not compared yet: beyond it, too many are hardly ever dominated to be worth the look."""
MOST_STEPS: Final = 600
"""Of the search; a problem that takes more is left to other searches, and has cost half a millisecond."""

Option = tuple[int, tuple[int, ...], tuple[int, ...]]
"""(value, costs, strategies by index in the table)"""


@dataclass(frozen=True, slots=True)
class SmallProblem:
    """A small problem without its capacities: the options of each class concerned, by falling value."""

    table: PreparedTable
    groups: list[list[Option]]

    def solve(self, capacities: Mapping[str, float]) -> tuple[int, ...] | None:
        """The lexicographic optimum under ``capacities``, as indices in the table; None if it takes too many steps.
        Raises Infeasible if the security desires cannot all be met, InvalidProblem."""
        room = [thousandths(capacities[name], "the capacity of ", name) for name in self.table.totals]
        return _search(self.groups, [*room, *(0 for _ in self.table.needed)])


def state_small(problem: SelectionProblem, relaxed: frozenset[str] = frozenset()) -> SmallProblem | None:
    """``problem`` without γ4 for the classes in ``relaxed``; None if it is not small. Raises as
    :meth:`SmallProblem.solve`."""
    table = problem.table
    if table.sets is None or not problem.capacities.keys() >= table.totals.keys():
        return None
    groups = _groups(problem, table.sets, relaxed)
    return SmallProblem(table, groups) if groups is not None else None


def solve_small(problem: SelectionProblem, relaxed: frozenset[str] = frozenset()) -> tuple[int, ...] | None:
    """The lexicographic optimum of ``problem``, as indices in its table; γ4 is dropped for the classes in ``relaxed``.

    None if the problem is not small. Raises Infeasible if the security desires cannot all be met, InvalidProblem.
    """
    stated = state_small(problem, relaxed)
    return stated.solve(problem.capacities) if stated is not None else None


def _groups(problem: SelectionProblem, sets: ClassSets, relaxed: frozenset[str]) -> list[list[Option]] | None:
    """The options of each class concerned, by falling value, without those that another dominates; None if there are
    too many."""
    table, desires = problem.table, problem.desires
    concerned = _concerned(problem, relaxed)
    together = 1
    for cls in concerned:
        # Alone and none are the fewest there are.
        together *= 1 + len(table.members[cls].all)
    if together > MOST_SETS_TOGETHER:
        return None
    of_intensity, of_utility, of_spare, spare = _weights(problem)
    # The radix of a criterion is one more than the greatest sum of all that are below it.
    count = len(table.strategies)
    thrift = thrift_resource(problem)
    thrift_column = table.columns.get(thrift) if thrift is not None else None
    per_strategy = 1 << count
    per_thrift = (count + 1) * per_strategy
    per_fresh = (table.totals.get(thrift or "", 0) + 1) * per_thrift
    per_worth = (count + 1) * per_fresh
    strongest = max([desire.intensity for desire in desires.values()], default=0.0)
    per_omega = (thousandths(strongest, "an intensity") * table.produced + 1) * per_worth
    previous = problem.previous
    kept = None
    if previous:
        kept = [strategy.name in previous for strategy in table.strategies]
    spare_column = table.columns.get(spare) if of_spare and spare is not None else None
    combinations = 1
    groups: list[list[Option]] = []
    for cls in concerned:
        desire = desires.get(cls)
        column = table.columns.get((cls,))
        wanted = intensity = 0
        if desire is not None:
            wanted = thousandths(desire.utility, "desired utility of ", cls)
            intensity = thousandths(desire.intensity, "intensity of ", cls)
        optional = desire is None or not desire.security or cls in relaxed
        gain = of_intensity * intensity * per_omega
        each = of_utility * per_omega + intensity * per_worth
        options: list[Option] = []
        listed = sets.of(table, cls)
        if listed is None:
            return None
        for own in listed:
            chosen, costs = own.strategies, own.costs
            size = len(chosen)
            fresh = size if kept is None else size - sum(kept[s] for s in chosen)
            value = own.order - size * per_strategy - fresh * per_fresh
            if thrift_column is not None:
                value -= costs[thrift_column] * per_thrift
            if spare_column is not None:
                value -= of_spare * costs[spare_column] * per_omega
            if wanted and own.produced >= wanted:
                filled = costs
                if column is not None:
                    filled = (*costs[:column], costs[column] + wanted, *costs[column + 1 :])
                options.append((value + gain + each * own.produced, filled, chosen))
            if optional and (column is not None or not size):
                options.append((value, costs, chosen))
        if not options:
            raise Infeasible
        options = _efficient(options)
        groups.append(options)
        combinations *= len(options)
        if combinations > MOST_COMBINATIONS:
            return None
    return groups


def _weights(problem: SelectionProblem) -> tuple[int, int, int, str | None]:
    weights = problem.weights
    if weights.intensity == weights.utility == 1.0 and not weights.spare:
        return 1000, 1000, 0, None
    return (
        thousandths(weights.intensity, "the weight of intensity"),
        thousandths(weights.utility, "the weight of utility"),
        thousandths(weights.spare, "the weight of spare capacity"),
        spare_resource(problem),
    )


def _concerned(problem: SelectionProblem, relaxed: frozenset[str]) -> list[str]:
    """The classes that are desired, and those they require over any distance, but for inhibited ones. Raises
    Infeasible for a class without strategies whose security is asked for."""
    table, desires = problem.table, problem.desires
    members, requires = table.members, table.required
    concerned: dict[str, None] = {}
    for cls, desire in desires.items():
        if desire.utility > 0:
            if cls in members:
                concerned[cls] = None
            elif desire.security and cls not in relaxed:
                raise Infeasible
    ahead = [cls for cls in concerned if cls in requires]
    while ahead:
        for cls in requires.get(ahead.pop(), ()):
            if cls not in concerned and cls in members:
                known = desires.get(cls)
                if known is None or known.utility > 0:
                    concerned[cls] = None
                    ahead.append(cls)
    return list(concerned)


def _efficient(options: list[Option]) -> list[Option]:
    """``options`` by falling value, without those that another dominates."""
    if len(options) < 2:
        return options
    options.sort(key=itemgetter(0), reverse=True)
    kept: list[Option] = []
    for option in options:
        costs = option[1]
        for better in kept:
            if all(map(le, better[1], costs)):
                break
        else:
            kept.append(option)
    return kept


def _search(groups: list[list[Option]], room: list[int]) -> tuple[int, ...] | None:
    """The strategies of the options of greatest value, one per group, whose costs ``room`` has; None if it takes too
    many steps. Raises Infeasible."""
    left = tuple(room)
    settled: list[int] = []
    open_groups: list[list[Option]] = []
    for group in groups:
        if len(group) == 1:
            left = tuple(map(sub, left, group[0][1]))
            settled += group[0][2]
        else:
            open_groups.append(group)
    # What costs most to change is decided first: the rest of the tree is soon not worth a look.
    open_groups.sort(key=_regret, reverse=True)
    size = len(open_groups)
    # Over the groups from each on: the most they can be worth, and the room that they need at least.
    worth, least = [0] * (size + 1), [(0,) * len(room)] * (size + 1)
    for place in range(size - 1, -1, -1):
        group = open_groups[place]
        worth[place] = worth[place + 1] + group[0][0]
        least[place] = tuple(map(add, least[place + 1], map(min, *(option[1] for option in group))))
    best: int | None = None
    found: list[tuple[int, ...]] = []
    path: list[tuple[int, ...]] = [()] * size
    steps = 0

    def go(place: int, value: int, left: tuple[int, ...]) -> None:
        nonlocal best, found, steps
        if place == size:
            best, found = value, path[:]
            return
        ahead, floor = worth[place + 1], least[place + 1]
        for gain, costs, chosen in open_groups[place]:
            total = value + gain
            if (best is not None and total + ahead <= best) or steps > MOST_STEPS:
                return
            steps += 1
            after = tuple(map(sub, left, costs))
            if all(map(le, floor, after)):
                path[place] = chosen
                go(place + 1, total, after)

    if not all(map(le, least[0], left)):
        raise Infeasible
    go(0, 0, left)
    if steps > MOST_STEPS:
        return None
    if best is None:
        raise Infeasible
    for chosen in found:
        settled += chosen
    settled.sort()
    return tuple(settled)


def _regret(group: list[Option]) -> int:
    return group[0][0] - group[1][0]
