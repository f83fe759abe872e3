"""Why each desire gets what it gets, and what would serve it better.

Every alternative is checked: the problem is solved again with more of one resource, or without one other desire, and
the alternative is given only if the optimum then serves the class as promised.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import combinations

from app.attention.desires import GRAIN, Desire
from app.attention.problem import Alternative, Problem, Reason, Selection, produced
from app.attention.solver import SolverFailed, solve
from app.attention.strategies import Resource, Strategy, exclusive


def explain(
    problem: Problem,
    selection: Selection,
    *,
    time_limit_s: float = 0.1,
    resources: Mapping[str, Resource] | None = None,
    give_up: Callable[[], bool] = lambda: False,
) -> dict[str, Reason]:
    """A reason for each desired class, in the problem's order.

    Alternatives are searched for the unfulfilled first, then for the more intense, until the time is over; 0 searches
    none. ``resources`` gives the units that texts use. ``give_up`` is asked before each step and ends the search too.
    """
    deadline = time.perf_counter() + time_limit_s
    search = _Search(problem, deadline, resources or {}, give_up)
    reasons: dict[str, Reason] = {}
    order = sorted(problem.desires.values(), key=lambda d: (d.cls in selection.fulfilled, -d.intensity))
    for desire in order:
        reasons[desire.cls] = _reason(problem, selection, desire, search if time_limit_s > 0 else None)
    return {cls: reasons[cls] for cls in problem.desires}


def best_utility(problem: Problem, cls: str) -> float:
    """The most utility that the strategies of ``cls`` can produce together, were resources without limit."""
    able = [s for s in problem.strategies if s.cls == cls and not _forbidden(problem, s)]
    if all(exclusive(one, other) for one, other in combinations(able, 2)):
        return max((s.utility for s in able), default=0.0)
    desire = next(iter(problem.desires.values()))
    alone = Problem(
        {cls: replace(desire, cls=cls, intensity=1.0, utility=0.001, security=False)},
        tuple(replace(s, costs={}, requires={}) for s in able),
        {},
    )
    return produced(alone, solve(alone).strategies, cls)


def _forbidden(problem: Problem, strategy: Strategy) -> bool:
    """Whether the strategy requires an inhibited class."""
    return any(
        required in problem.desires and problem.desires[required].utility == 0
        for required, amount in strategy.requires.items()
        if amount > 0
    )


def _reason(problem: Problem, selection: Selection, desire: Desire, search: _Search | None) -> Reason:
    cls, wanted = desire.cls, desire.utility
    if wanted == 0:
        text = f"inhibited by a desire of intensity {desire.intensity:g}"
        return Reason("inhibited", 0.0, 0.0, 0.0, text)
    best = best_utility(problem, cls)
    got = produced(problem, selection.strategies, cls) if cls in selection.fulfilled else 0.0
    by = ", ".join(s.name for s in problem.strategies if s.cls == cls and s.name in selection.strategies)
    if got and got >= best:
        return Reason("fulfilled", got, wanted, best, f"fulfilled at its best ({got:g}) by {by}")
    alternatives: tuple[Alternative, ...] = ()
    why = "" if got else _obstacle(problem, desire, best)
    if search is not None and not why:
        alternatives = search.alternatives(cls, at_least=best if got else wanted)
        if not alternatives and got:
            alternatives = search.alternatives(cls, at_least=got + 0.001)
    elif search is not None and _inhibitors(problem, cls):
        alternatives = search.without(cls, wanted)
    units = search.resources if search is not None else {}
    offer = " or ".join(_words(alternative, units) for alternative in alternatives)
    if got:
        text = f"fulfilled at {got:g} of {best:g} by {by}"
        if offer:
            text += f"; would get {alternatives[0].utility:g} {offer}"
        return Reason("degraded", got, wanted, best, text, alternatives)
    text = f"unfulfilled: {why}" if why else "unfulfilled: what it needs does not fit beside what is worth more"
    if cls in selection.relaxed:
        text += ", though its security is asked for"
    if offer:
        text += f"; would be fulfilled {offer}"
    return Reason("unfulfilled", 0.0, wanted, best, text, alternatives)


def _obstacle(problem: Problem, desire: Desire, best: float) -> str:
    """Why no amount of resources could fulfil the desire; "" if some could."""
    able = [s for s in problem.strategies if s.cls == desire.cls]
    if not able:
        return "no strategy serves this class"
    inhibitors = _inhibitors(problem, desire.cls)
    if best < desire.utility and inhibitors:
        return f"it depends on {' and '.join(inhibitors)}, which is inhibited"
    if best < desire.utility:
        return f"it asks for utility {desire.utility:g}, its strategies produce at most {best:g}"
    served = {s.cls for s in problem.strategies}
    missing = [{c for c in s.requires if c not in served} for s in able if s.utility >= desire.utility]
    if missing and all(missing):
        return f"it depends on {' and '.join(sorted(set.union(*missing)))}, which no strategy serves"
    return ""


def _inhibitors(problem: Problem, cls: str) -> list[str]:
    """The inhibited classes that strategies of ``cls`` require."""
    required = {c for s in problem.strategies if s.cls == cls for c, amount in s.requires.items() if amount > 0}
    return sorted(c for c in required if c in problem.desires and problem.desires[c].utility == 0)


class _Search:
    """Solves variants of a problem until a deadline."""

    def __init__(
        self, problem: Problem, deadline: float, resources: Mapping[str, Resource], give_up: Callable[[], bool]
    ) -> None:
        self.problem = problem
        self.deadline = deadline
        self.resources = resources
        self.give_up = give_up

    def alternatives(self, cls: str, at_least: float) -> tuple[Alternative, ...]:
        """What would give ``cls`` at least that utility: more of one resource, or one desire less."""
        found = [a for resource in self.problem.capacities if (a := self._more(cls, resource, at_least)) is not None]
        return (*found, *self.without(cls, at_least))

    def without(self, cls: str, at_least: float) -> tuple[Alternative, ...]:
        """The other desires of which any one's absence would give ``cls`` at least that utility."""
        found = []
        for other in self.problem.desires:
            if other != cls:
                got, _ = self._got(self.problem.without(other), cls)
                if got >= at_least:
                    found.append(Alternative("without", got, without=other))
        return tuple(found)

    def _more(self, cls: str, resource: str, at_least: float) -> Alternative | None:
        """The least more of ``resource``, within a hundredth of what there is, that gives ``cls`` that utility."""
        problem = self.problem
        if not any(s.costs.get(resource) for s in problem.strategies if s.cls in (cls, *_needed_by(problem, cls))):
            return None
        capacity = problem.capacities[resource]
        total = round(sum(s.costs.get(resource, 0.0) for s in problem.strategies), 3)
        got, selection = self._got(problem.with_capacity(resource, max(capacity, total)), cls)
        if got < at_least or selection is None or selection.use[resource] <= capacity:
            return None
        # In whole thousandths: how much is enough, how much falls short.
        enough, utility, short = round(selection.use[resource] * GRAIN), got, round(capacity * GRAIN)
        grain = max(short // 100, 1)
        while enough - short > grain:
            middle = (enough + short) // 2
            got, selection = self._got(problem.with_capacity(resource, middle / GRAIN), cls)
            if got >= at_least and selection is not None and selection.use[resource] > capacity:
                enough, utility = round(selection.use[resource] * GRAIN), got
            else:
                short = middle
        unit = self.resources[resource].unit if resource in self.resources else ""
        return Alternative(
            "capacity", utility, resource=resource, amount=round(enough / GRAIN - capacity, 3), unit=unit
        )

    def _got(self, problem: Problem, cls: str) -> tuple[float, Selection | None]:
        """The utility ``cls`` gets at the optimum of ``problem``; 0 when the time is over."""
        left = self.deadline - time.perf_counter()
        if left <= 0 or self.give_up():
            return 0.0, None
        try:
            selection = solve(problem, time_limit_s=left)
        except SolverFailed:
            return 0.0, None
        if not selection.proven or cls not in selection.fulfilled:
            return 0.0, selection
        return produced(problem, selection.strategies, cls), selection


def _needed_by(problem: Problem, cls: str) -> set[str]:
    """The classes that strategies of ``cls`` require, over any distance."""
    found: set[str] = set()
    ahead = [cls]
    while ahead:
        current = ahead.pop()
        for strategy in problem.strategies:
            if strategy.cls == current:
                fresh = set(strategy.requires) - found
                found |= fresh
                ahead += fresh
    return found


def _words(alternative: Alternative, resources: Mapping[str, Resource]) -> str:
    """``with 18 % more cpu``, ``without LocateVoices``."""
    if alternative.kind == "without":
        return f"without {alternative.without}"
    unit = resources[alternative.resource].unit.partition(" of ")[0] if alternative.resource in resources else ""
    amount = f"{alternative.amount:g} {unit}".strip()
    return f"with {amount} more {alternative.resource}"
