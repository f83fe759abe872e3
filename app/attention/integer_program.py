"""A selection problem in whole numbers, the input of both exact searches.

Strategies that cannot be part of any useful selection are left out: those of classes without a desire that no strategy
requires, those of inhibited classes or requiring one, and those too weak for their class where nothing else needs it.

The objective is lexicographic: Ω first, then the ties of ARCHITECTURE.md in order. Each criterion is a whole-number
linear form; :attr:`IntegerProgram.fulfil`, ``serve`` and ``pay`` hold them combined into one whole number in mixed
radix (Python's integers have no bound), :attr:`IntegerProgram.criteria` one by one.

1. Ω, in 10⁻⁶ (weights and values are thousandths)
2. Σ i' f a v: more utility to the more intense desire
3. fewest strategies that were not selected before: no needless switch
4. least use of the thrift resource (CPU)
5. fewest strategies
6. table order: of the first strategy in which two selections differ, the one that has it

By 3 to 5 no selection contains strategies that serve nothing: without them it is never worse, and by 5 better.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from app.attention.prepared import InvalidProblem, PreparedTable, all_exclude, thousandths
from app.attention.problem import SelectionProblem, spare_resource, thrift_resource


class Infeasible(Exception):
    """No selection meets every security desire."""


@dataclass(frozen=True, slots=True)
class ProgramSolution:
    """``chosen`` kept-strategy indices s; ``bound`` of Ω in 10⁻⁶ (without the offset); ``proven`` optimal in every
    criterion."""

    chosen: tuple[int, ...]
    bound: int
    proven: bool


@dataclass(frozen=True, slots=True)
class Criterion:
    """One linear form to maximise: Σ_k fulfil_k f_k + Σ_s serve_s f_k(s) a_s - Σ_s pay_s a_s, its value in [-low,
    high]."""

    fulfil: dict[int, int]
    serve: tuple[int, ...]
    pay: tuple[int, ...]
    low: int
    high: int


@dataclass(frozen=True, slots=True)
class IntegerProgram:
    """Whole numbers only. Index s counts the strategies kept, k the classes concerned.

    ``table`` (s) index in the problem's table; ``cls`` (s) class k; ``utility`` (s) v; ``requires`` (s) {k: l};
    ``resources`` those that may not suffice; ``costs`` (s) a c of each of them; ``capacities`` their m; ``members`` (k)
    its s; ``exclusive`` (k) whether they all exclude each other; ``cliques`` (k) where not, groups of them of which at
    most one can be chosen; ``desired`` {k: u'} with u' > 0; ``needed`` the k that some kept strategy requires;
    ``security`` the k with z' = 1 kept; ``impossible``: a security class has no strategy at all.
    """

    problem: SelectionProblem
    classes: tuple[str, ...]
    table: tuple[int, ...]
    cls: tuple[int, ...]
    utility: tuple[int, ...]
    requires: tuple[dict[int, int], ...]
    resources: tuple[str, ...]
    costs: tuple[tuple[int, ...], ...]
    capacities: tuple[int, ...]
    members: tuple[tuple[int, ...], ...]
    cliques: tuple[tuple[tuple[int, ...], ...], ...]
    exclusive: tuple[bool, ...]
    desired: dict[int, int]
    needed: frozenset[int]
    security: frozenset[int]
    impossible: bool
    criteria: tuple[Criterion, ...]
    fulfil: dict[int, int]
    serve: tuple[int, ...]
    pay: tuple[int, ...]
    omega_unit: int
    omega_shift: int
    omega_offset: int

    def value(self, chosen: tuple[int, ...]) -> int:
        """The combined objective of a selection that breaks no constraint."""
        total = -sum(self.pay[s] for s in chosen)
        for k, wanted in self.desired.items():
            cover = sum(self.utility[s] for s in chosen if self.cls[s] == k)
            cover -= sum(self.requires[s].get(k, 0) for s in chosen)
            if cover >= wanted:
                total += self.fulfil[k] + sum(self.serve[s] for s in chosen if self.cls[s] == k)
        return total

    def omega_criterion(self, value: int) -> int:
        """Ω in 10⁻⁶ without the offset, from a combined objective (an upper bound of the one from one of the other)."""
        return (value + self.omega_shift) // self.omega_unit

    def omega_of(self, millionths: int) -> float:
        """Ω from the value of its criterion."""
        return round((millionths + self.omega_offset) / 1e6, 6)


def build_integer_program(
    problem: SelectionProblem, *, relaxed: frozenset[str] = frozenset(), roomier: bool = False
) -> IntegerProgram:
    """The whole-number form of ``problem``; γ4 is dropped for the classes in ``relaxed``. Raises InvalidProblem.

    ``roomier``: it shall serve greater capacities too, so strategies that cost more than there is are kept."""
    desires = problem.desires
    table = problem.table
    inhibited = {cls for cls, desire in desires.items() if desire.utility == 0}
    limits = {name: thousandths(value, "the capacity of ", name) for name, value in problem.capacities.items()}
    kept = _useful(problem, table, inhibited, dict.fromkeys(limits, math.inf) if roomier else limits)
    number: dict[str, int] = {}
    for index in kept:
        number.setdefault(table.strategies[index].cls, len(number))
    for index in kept:
        for c in table.strategies[index].requires:
            number.setdefault(c, len(number))
    for c, d in desires.items():
        if d.security and c not in inhibited:
            number.setdefault(c, len(number))
    names = tuple(number)

    cost_of = [table.costs[index] for index in kept]
    cls = tuple(number[table.strategies[index].cls] for index in kept)
    members: list[list[int]] = [[] for _ in names]
    for s_index, k in enumerate(cls):
        members[k].append(s_index)
    # A resource that all kept strategies together cannot use up never binds.
    totals = dict.fromkeys(limits, 0)
    for costs in cost_of:
        for r, cost in costs.items():
            totals[r] += cost
    binding = [r for r, limit in limits.items() if totals[r] > limit]
    utility = tuple(table.utility[index] for index in kept)
    requires = tuple({number[c]: amount for c, amount in table.requires[index].items()} for index in kept)
    cliques, exclusive = _exclusion(table, kept, names, members)
    desired = {
        number[c]: thousandths(d.utility, "desired utility of ", c)
        for c, d in desires.items()
        if c in number and c not in inhibited
    }
    security = frozenset(number[c] for c, d in desires.items() if d.security and c in number and c not in relaxed)
    intensity = {k: thousandths(desires[names[k]].intensity, "intensity of ", names[k]) for k in desired}

    thrift, spare = thrift_resource(problem), spare_resource(problem)
    criteria = _criteria(
        problem,
        intensity,
        cls=cls,
        utility=utility,
        fresh=tuple(int(table.strategies[index].name not in problem.previous) for index in kept),
        thrift_cost=tuple(costs.get(thrift, 0) if thrift else 0 for costs in cost_of),
        spare_cost=tuple(costs.get(spare, 0) if spare else 0 for costs in cost_of),
    )
    fulfil, serve, pay, omega_unit, omega_shift = _combined(criteria, frozenset(desired))
    return IntegerProgram(
        problem=problem,
        classes=names,
        table=tuple(kept),
        cls=cls,
        utility=utility,
        requires=requires,
        resources=tuple(binding),
        costs=tuple(tuple(costs.get(r, 0) for r in binding) for costs in cost_of),
        capacities=tuple(limits[r] for r in binding),
        members=tuple(tuple(group) for group in members),
        cliques=cliques,
        exclusive=exclusive,
        desired=desired,
        needed=frozenset(k for needs in requires for k in needs),
        security=security,
        impossible=any(not members[k] for k in security),
        criteria=criteria,
        fulfil=fulfil,
        serve=serve,
        pay=pay,
        omega_unit=omega_unit,
        omega_shift=omega_shift,
        omega_offset=_weight(problem, "spare") * (limits[spare] if spare else 0),
    )


def _exclusion(
    table: PreparedTable, kept: list[int], names: tuple[str, ...], members: list[list[int]]
) -> tuple[tuple[tuple[tuple[int, ...], ...], ...], tuple[bool, ...]]:
    """By class k, its cliques among the strategies kept, and whether these all exclude each other."""
    place: dict[int, int] = {}
    cliques: list[tuple[tuple[int, ...], ...]] = []
    exclusive: list[bool] = []
    for name, group in zip(names, members, strict=True):
        known = table.members.get(name)
        if known is None or known.exclusive or len(group) < 2:
            # Groups are not needed where one of all is chosen anyway.
            cliques.append(())
            exclusive.append(True)
            continue
        place = place or {index: s for s, index in enumerate(kept)}
        left = (tuple(place[index] for index in clique if index in place) for clique in known.cliques)
        mine = tuple(clique for clique in left if len(clique) > 1)
        cliques.append(mine)
        exclusive.append(all_exclude(group, mine))
    return tuple(cliques), tuple(exclusive)


def _weight(problem: SelectionProblem, of: Literal["intensity", "utility", "spare"]) -> int:
    title = "spare capacity" if of == "spare" else of
    return thousandths(getattr(problem.weights, of), f"the weight of {title}")


def _criteria(
    problem: SelectionProblem,
    intensity: dict[int, int],
    cls: tuple[int, ...],
    utility: tuple[int, ...],
    fresh: tuple[int, ...],
    thrift_cost: tuple[int, ...],
    spare_cost: tuple[int, ...],
) -> tuple[Criterion, ...]:
    """The six of the module's docstring. ``intensity`` {k: i} of the classes desired; by strategy s, ``cls`` is its k,
    ``fresh`` 1 where it was not selected before, ``thrift_cost`` what it takes of the thrift resource, ``spare_cost``
    of the one whose unused part counts in Ω."""
    of_intensity, of_utility, of_spare = (_weight(problem, of) for of in ("intensity", "utility", "spare"))
    count = len(utility)
    zeros = (0,) * count
    omega = _criterion(
        {k: of_intensity * i for k, i in intensity.items()},
        tuple(of_utility * v if k in intensity else 0 for k, v in zip(cls, utility, strict=True)),
        tuple(of_spare * c for c in spare_cost),
    )
    return (
        omega,
        _criterion({}, tuple(intensity.get(k, 0) * v for k, v in zip(cls, utility, strict=True)), zeros),
        _criterion({}, zeros, fresh),
        _criterion({}, zeros, thrift_cost),
        _criterion({}, zeros, (1,) * count),
        _criterion({}, zeros, tuple(-(1 << (count - 1 - s)) for s in range(count))),
    )


def _combined(
    criteria: tuple[Criterion, ...], desired: frozenset[int]
) -> tuple[dict[int, int], tuple[int, ...], tuple[int, ...], int, int]:
    """``fulfil``, ``serve`` and ``pay`` of all in mixed radix; of the first, its unit and its shift (the least of what
    is below it)."""
    fulfil = dict.fromkeys(desired, 0)
    serve = pay = (0,) * len(criteria[0].serve)
    unit, top, low, shift = 1, 1, 0, 0
    for criterion in reversed(criteria):
        for k, gain in criterion.fulfil.items():
            fulfil[k] += unit * gain
        serve = tuple(total + unit * gain for total, gain in zip(serve, criterion.serve, strict=True))
        pay = tuple(total + unit * cost for total, cost in zip(pay, criterion.pay, strict=True))
        top, shift = unit, low
        low += unit * criterion.low
        unit *= criterion.high + criterion.low + 1
    return fulfil, serve, pay, top, shift


def _useful(
    problem: SelectionProblem, table: PreparedTable, inhibited: set[str], limits: Mapping[str, float]
) -> list[int]:
    """Indices of the strategies that may serve: of desired classes, and of what those require, over any distance.

    Raises InvalidProblem for one that costs what there is nothing of.
    """
    seen = dict.fromkeys(c for c in problem.desires if c in table.members and c not in inhibited)
    ahead = list(seen)
    kept: list[int] = []
    while ahead:
        for index in table.members[ahead.pop()].all:
            needs = table.requires[index]
            if needs and not inhibited.isdisjoint(needs):
                continue
            costs = table.costs[index]
            for resource in costs:
                if resource not in limits:
                    name = table.strategies[index].name
                    raise InvalidProblem(f"strategy {name!r} costs {resource!r}, which has no capacity")
            if any(cost > limits[resource] for resource, cost in costs.items()):
                continue
            kept.append(index)
            for c in needs:
                if c not in seen and c in table.members and c not in inhibited:
                    seen[c] = None
                    ahead.append(c)
    return sorted(kept)


def _criterion(fulfil: dict[int, int], serve: tuple[int, ...], pay: tuple[int, ...]) -> Criterion:
    high = sum(fulfil.values()) + sum(serve) + sum(-p for p in pay if p < 0)
    return Criterion(fulfil, serve, pay, low=sum(p for p in pay if p > 0), high=high)


def table_order(count: int, chunk: int = 30) -> Iterator[Criterion]:
    """Table order in pieces of ``chunk`` strategies, the first of them deciding first."""
    for start in range(0, count, chunk):
        stop = min(start + chunk, count)
        pay = tuple(-(1 << (stop - 1 - s)) if start <= s < stop else 0 for s in range(count))
        yield Criterion({}, (0,) * count, pay, 0, (1 << (stop - start)) - 1)
