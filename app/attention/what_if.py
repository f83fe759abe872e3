"""What attention would choose under other desires, costs and budgets. Nothing is put in force."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from app.attention.desires import GRAIN, Desire, Source, checked_number
from app.attention.intention import Intention, divisors_of, parameters_of
from app.attention.problem import SelectionProblem
from app.attention.reasons import explain
from app.attention.solver import solve
from app.attention.strategies import Resource, Strategy
from app.messages import Asked

#: The author of desires that are only supposed.
SUPPOSED: Final = Source("rest", "what-if")


class UnknownNames(ValueError):
    """A supposition is about what does not exist: ``names``, each as ``member.name``."""

    def __init__(self, names: Collection[str]) -> None:
        self.names = tuple(names)
        super().__init__(f"there is no such thing: {', '.join(self.names)}")


@dataclass(frozen=True, slots=True)
class Supposition:
    """What is supposed; all else is as it is.

    ``desires`` by class: what its strongest desire asks for, or None, no desire; ``costs`` by strategy and resource;
    ``capacities`` by resource.
    """

    desires: Mapping[str, Asked | None] = field(default_factory=dict)
    costs: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    capacities: Mapping[str, float] = field(default_factory=dict)


def supposed(problem: SelectionProblem, supposition: Supposition, stamp: float) -> SelectionProblem:
    """``problem`` under ``supposition``; costs and capacities in thousandths, cut off as those in force are.

    A supposed desire keeps the parameters of the desire that is there. Raises UnknownNames for a strategy or a resource
    that there is not (desire classes are not checked), InvalidDesire for an intensity or a utility out of its scale.
    """
    _refuse_unknown(problem, supposition)
    desires = dict(problem.desires)
    for cls, asked in supposition.desires.items():
        known = desires.pop(cls, None)
        if asked is not None:
            desires[cls] = _desire(cls, asked, known, stamp)
    capacities = {name: _grained(supposition.capacities.get(name, is_)) for name, is_ in problem.capacities.items()}
    changed = replace(problem, desires=desires, capacities=capacities)
    if not supposition.costs:
        return changed
    strategies = tuple(_with_costs(strategy, supposition.costs) for strategy in problem.strategies)
    return replace(changed, strategies=strategies, prepared=None)


def intention_if(
    problem: SelectionProblem,
    supposition: Supposition,
    stamp: float,
    *,
    controlled: Collection[str],
    resources: Mapping[str, Resource],
    time_limit_s: float,
    explain_limit_s: float,
) -> Intention:
    """The intention that would follow from ``problem`` under ``supposition``, with its reasons. Blocks.

    ``controlled`` are the filters that attention sets. Raises UnknownNames, InvalidDesire, InvalidProblem and
    SolverFailed.
    """
    asked = supposed(problem, supposition, stamp).with_table()
    selection = solve(asked, time_limit_s=time_limit_s)
    names = frozenset(selection.strategies)
    chosen = tuple(strategy for strategy in asked.strategies if strategy.name in names)
    return Intention(
        stamp=stamp,
        selection=selection,
        strategies=chosen,
        divisors=divisors_of(chosen, controlled),
        parameters=parameters_of(chosen, asked.desires),
        reasons=explain(asked, selection, time_limit_s=explain_limit_s, resources=resources),
        desires=asked.desires,
        capacities=asked.capacities,
        previous=asked.previous,
        weights=asked.weights,
    )


def _refuse_unknown(problem: SelectionProblem, supposition: Supposition) -> None:
    strategies = {strategy.name for strategy in problem.strategies}
    unknown = [f"costs.{name}" for name in supposition.costs if name not in strategies]
    for name, costs in supposition.costs.items():
        unknown += [f"costs.{name}.{resource}" for resource in costs if resource not in problem.capacities]
    unknown += [f"capacities.{name}" for name in supposition.capacities if name not in problem.capacities]
    if unknown:
        raise UnknownNames(unknown)


def _desire(cls: str, asked: Asked, known: Desire | None, stamp: float) -> Desire:
    return Desire(
        id="" if known is None else known.id,
        cls=cls,
        intensity=checked_number("intensity", asked.intensity, above=0),
        utility=checked_number("utility", asked.utility),
        security=asked.security,
        params={} if known is None else known.params,
        source=SUPPOSED,
        created=stamp,
    )


def _with_costs(strategy: Strategy, costs: Mapping[str, Mapping[str, float]]) -> Strategy:
    given = costs.get(strategy.name)
    if given is None:
        return strategy
    return replace(strategy, costs={**strategy.costs, **{name: _grained(cost) for name, cost in given.items()}})


def _grained(value: float) -> float:
    return math.floor(value * GRAIN + 1e-6) / GRAIN
