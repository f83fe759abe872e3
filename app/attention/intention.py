"""An intention: the filters Φ' and parameters P' that follow from a selection (thesis 4.2.5, *Intention
Generation*)."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from app.attention.desires import Desire
from app.attention.problem import Selection, Weights
from app.attention.strategies import CLOSED, Strategy
from app.messages import Reason


@dataclass(frozen=True, slots=True)
class Intention:
    """The selection in force and its consequences.

    ``stamp`` when it was applied; ``selection`` the solver's answer; ``strategies`` those selected; ``divisors`` φ of
    every filter that some strategy of the table sets (math.inf: closed); ``parameters`` P' by module; ``reasons`` by
    desired class; ``desires`` the strongest of each class at the time; ``capacities`` the budgets at the time;
    ``previous`` the strategies that were selected then; ``weights`` those of Ω; ``changed`` the
    strategies that cost or produce otherwise than in the table the translator began with.
    """

    stamp: float
    selection: Selection
    strategies: tuple[Strategy, ...]
    divisors: Mapping[str, float]
    parameters: Mapping[str, Mapping[str, Any]]
    reasons: Mapping[str, Reason]
    desires: Mapping[str, Desire]
    capacities: Mapping[str, float]
    previous: frozenset[str] = frozenset()
    weights: Weights = field(default_factory=Weights)
    changed: tuple[Strategy, ...] = ()


def divisors_of(strategies: Collection[Strategy], controlled: Collection[str]) -> dict[str, float]:
    """Φ': φ of each controlled filter. Of several strategies that set one, the smallest φ wins; a filter that none sets
    is closed."""
    divisors = dict.fromkeys(sorted(controlled), CLOSED)
    for strategy in strategies:
        for name, divisor in strategy.filters.items():
            divisors[name] = min(divisors[name], divisor)
    return divisors


def parameters_of(strategies: Collection[Strategy], desires: Mapping[str, Desire]) -> dict[str, dict[str, Any]]:
    """P': the parameters of each module: of each selected strategy, the parameters of its class's desire, overridden by
    its own, on which its utility and costs depend.

    Where several classes set parameters of one module, the more intense desire overrides.
    """
    parameters: dict[str, dict[str, Any]] = {}
    ordered = sorted(strategies, key=lambda s: desires[s.cls].intensity if s.cls in desires else 0.0)
    for strategy in ordered:
        desire = desires.get(strategy.cls)
        for module in strategy.modules:
            mine = parameters.setdefault(module, {})
            if desire is not None:
                mine.update(desire.params)
            mine.update(strategy.parameters.get(module, {}))
    return {module: mine for module, mine in parameters.items() if mine}
