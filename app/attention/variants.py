"""Variants of a problem: more of a resource, or one desire less, and the utility that a class would get then. They are
solved until a deadline, each once for all classes."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from app.attention.branching import SmallProblem, state_small
from app.attention.desires import GRAIN
from app.attention.integer_program import Infeasible
from app.attention.problem import Selection, SelectionProblem
from app.attention.solver import GRADED, SolverFailed, load, solve
from app.attention.strategies import Resource
from app.messages import Alternative

if TYPE_CHECKING:
    from app.attention.compiled_variants import CompiledProblem

_COMPILED: Final = "app.attention.compiled_variants"
_FEW: Final = 20
"""Desires whose reasons are found sooner than the compiled search is loaded, where it is not yet."""


@dataclass(frozen=True, slots=True)
class _Optimum:
    """A proven selection, in thousandths: ``got`` is the utility of each class it fulfils; ``use`` by resource."""

    got: Mapping[str, int]
    use: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class _Span:
    """From ``least`` to ``most`` thousandths of a resource the optimum is this one."""

    least: int
    most: int
    optimum: _Optimum


class Variants:
    """Solves variants of ``problem``, whose optimum is ``selection``, until ``deadline`` (of ``time.perf_counter``).

    Two facts save most of the work. An optimum under a capacity is the optimum under every smaller one that it fits
    into. And a desire that is not fulfilled takes nothing from others: without it, the optimum is the same. ``missing``
    becomes True if a requested variant was not solved in time; ``bounds`` has the (class, resource) of which an
    alternative says more than may be needed, for that reason.
    """

    def __init__(
        self,
        problem: SelectionProblem,
        selection: Selection,
        resources: Mapping[str, Resource],
        deadline: float,
        give_up: Callable[[], bool],
    ) -> None:
        self._problem = problem
        self._table = problem.table
        self._resources = resources
        self._deadline = deadline
        self._give_up = give_up
        self._takes_s = selection.solve_time_s / 2
        self._base = self._optimum(selection) if selection.proven else None
        self._spans: dict[str, list[_Span]] = {name: [] for name in problem.capacities}
        if self._base is not None:
            for name, capacity in problem.capacities.items():
                self._spans[name].append(_span(self._base, name, round(capacity * GRAIN)))
        self._without: dict[str, _Optimum] = {}
        fulfilled = frozenset(selection.fulfilled)
        #: Classes whose desire affects the optimum.
        self._taking = tuple(
            cls for cls, d in problem.desires.items() if self._base is None or cls in fulfilled or d.utility == 0
        )
        self._wants: dict[str, frozenset[str]] = {}
        self._small = _stated(problem)
        self._compiled = self._compile(selection) if self._small is None else None
        self.missing = False
        self.bounds: set[tuple[str, str]] = set()

    def alternatives(self, cls: str, at_least: float) -> tuple[Alternative, ...]:
        """Changes that would give ``cls`` at least that utility: more of one resource, or one desire less."""
        found = [a for resource in self._problem.capacities if (a := self._more(cls, resource, at_least)) is not None]
        return (*found, *self.without(cls, at_least))

    def without(self, cls: str, at_least: float) -> tuple[Alternative, ...]:
        """The other desires of which any one's absence would give ``cls`` at least that utility."""
        wanted, found = round(at_least * GRAIN), []
        others = self._taking
        if self._over() if self._compiled is not None else self._no_time():
            # Only variants solved for other classes are used.
            self.missing = self.missing or not self._without.keys() >= set(others) - {cls}
            others = tuple(self._without)
        for other in others:
            optimum = self._lacking(other) if other != cls else None
            if optimum is not None and optimum.got.get(cls, 0) >= wanted:
                found.append(Alternative("without", optimum.got[cls] / GRAIN, without=other))
        return tuple(found)

    def _more(self, cls: str, resource: str, at_least: float) -> Alternative | None:
        """The least more of ``resource``, within a hundredth of what there is, that gives ``cls`` that utility."""
        wanted, capacity = round(at_least * GRAIN), round(self._problem.capacities[resource] * GRAIN)
        total = self._table.totals.get(resource, 0)
        if total <= capacity or resource not in self._wanted_by(cls):
            return None
        if self._compiled is not None and resource not in self._compiled.row:
            # There is enough of it, whatever is selected.
            return None
        grain = max(capacity // 100, 1)

        def enough_at(most: int) -> _Optimum | None:
            optimum = self._with(resource, most)
            if optimum is None or optimum.got.get(cls, 0) < wanted or optimum.use[resource] <= capacity:
                return None
            return optimum

        best = enough_at(total)
        if best is None:
            return None
        short, most, halving = capacity, min(total, best.use[resource]), True
        while (enough := best.use[resource]) - short > grain and most - short > grain:
            if self._small is not None or self._compiled is not None:
                # By halves of what there could be at most: other classes then ask for the same amounts.
                at = (most + short) // 2
            else:
                # By halves; but optima change in steps, so a look just below what is enough often ends the search.
                at = (enough + short) // 2 if halving else enough - grain
            if at < enough and self._with(resource, at) is None:
                self.bounds.add((cls, resource))
                break
            optimum = enough_at(at) if at < enough else best
            halving = optimum is not None
            best, short, most = (best, at, most) if optimum is None else (optimum, short, at)
        unit = self._resources[resource].unit if resource in self._resources else ""
        amount = round((best.use[resource] - capacity) / GRAIN, 3)
        return Alternative("capacity", best.got[cls] / GRAIN, resource=resource, amount=amount, unit=unit)

    def _with(self, resource: str, capacity: int) -> _Optimum | None:
        """The optimum with ``capacity`` thousandths of ``resource``; None if there was no time to find it."""
        spans = self._spans[resource]
        for span in spans:
            if span.least <= capacity <= span.most:
                return span.optimum
        optimum = None
        if self._compiled is not None and not self._over():
            found = self._compiled.under(resource, capacity, self._deadline)
            optimum = _Optimum(found[0], {resource: found[1]}) if found is not None else None
        if optimum is None:
            optimum = self._solved(self._problem.with_capacity(resource, capacity / GRAIN), self._small)
        if optimum is not None:
            spans.append(_span(optimum, resource, capacity))
        return optimum

    def _lacking(self, other: str) -> _Optimum | None:
        """The optimum without the desire for ``other``; None if there was no time to find it."""
        known = self._without.get(other)
        if known is None and self._compiled is not None and other in self._compiled.number and not self._over():
            got = self._compiled.without(other, self._deadline) if self._problem.desires[other].utility else None
            known = _Optimum(got, {}) if got is not None else None
            if known is not None:
                self._without[other] = known
        if known is None:
            changed = self._problem.without(other)
            known = self._solved(changed, _stated(changed) if self._small else None)
            if known is not None:
                self._without[other] = known
        return known

    def _solved(self, variant: SelectionProblem, small: SmallProblem | None) -> _Optimum | None:
        """The optimum of ``variant``, ``small`` if it can be stated so; None if there was no time to find it."""
        if self._no_time():
            self.missing = True
            return None
        began = time.perf_counter()
        try:
            chosen = small.solve(variant.capacities) if small is not None else None
        except Infeasible:
            chosen = None
        if chosen is not None:
            return self._optimum_of(chosen)
        try:
            selection = solve(variant, time_limit_s=self._deadline - began, firm=True)
        except SolverFailed:
            self.missing = True
            return None
        if not selection.proven:
            self.missing = True
            return None
        took = time.perf_counter() - began
        self._takes_s = min(self._takes_s or took, took)
        return self._optimum(selection)

    def _compile(self, selection: Selection) -> CompiledProblem | None:
        """The problem for the compiled search; None where it is not for it, or would not be there in time."""
        if selection.relaxed or self._over():
            return None
        if len(self._problem.desires) <= _FEW and GRADED not in sys.modules:
            return None
        module = load(_COMPILED, self._deadline)
        compiled: CompiledProblem | None = None
        if module is not None:
            compiled = module.compile_problem(self._problem, self._deadline)
        return compiled

    def _no_time(self) -> bool:
        """Whether what is left is too little for another: it would only be cut off."""
        return self._deadline - time.perf_counter() <= self._takes_s or self._give_up()

    def _over(self) -> bool:
        """Whether there is no time at all."""
        return time.perf_counter() >= self._deadline or self._give_up()

    def _optimum(self, selection: Selection) -> _Optimum:
        names = frozenset(selection.strategies)
        return self._optimum_of([index for index, s in enumerate(self._table.strategies) if s.name in names])

    def _optimum_of(self, chosen: Collection[int]) -> _Optimum:
        """The optimum that selects ``chosen``, by index in the table."""
        table = self._table
        made: dict[str, int] = {}
        cover: dict[str, int] = {}
        use = dict.fromkeys(self._problem.capacities, 0)
        for index in chosen:
            cls = table.strategies[index].cls
            made[cls] = made.get(cls, 0) + table.utility[index]
            for required, need in table.requires[index].items():
                cover[required] = cover.get(required, 0) - need
            for resource, cost in table.costs[index].items():
                use[resource] += cost
        desires = self._problem.desires
        got = {
            cls: utility
            for cls, utility in made.items()
            if cls in desires and utility + cover.get(cls, 0) >= round(desires[cls].utility * GRAIN)
        }
        return _Optimum(got, use)

    def _wanted_by(self, cls: str) -> frozenset[str]:
        """The resources that strategies of ``cls``, and of what it requires over any distance, cost."""
        known = self._wants.get(cls)
        if known is not None:
            return known
        wanted: set[str] = set()
        seen, ahead = {cls}, [cls]
        while ahead:
            members = self._table.members.get(ahead.pop())
            for index in members.all if members is not None else ():
                wanted.update(self._table.costs[index])
                for required in self._table.requires[index]:
                    if required not in seen:
                        seen.add(required)
                        ahead.append(required)
            if len(wanted) == len(self._problem.capacities):
                break
        return self._wants.setdefault(cls, frozenset(wanted))


def _span(optimum: _Optimum, resource: str, capacity: int) -> _Span:
    return _Span(optimum.use[resource], capacity, optimum)


def _stated(problem: SelectionProblem) -> SmallProblem | None:
    try:
        return state_small(problem)
    except Infeasible:
        return None
