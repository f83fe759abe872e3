"""An intention: the filters Φ' and parameters P' that follow from a selection (thesis 4.2.5, *Intention
Generation*)."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from app.attention.desires import Desire
from app.attention.problem import Reason, Selection
from app.attention.strategies import CLOSED, Strategy


@dataclass(frozen=True, slots=True)
class Intention:
    """What the robot attends to.

    ``stamp`` when it was applied; ``selection`` the solver's answer; ``strategies`` those selected; ``divisors`` φ of
    every filter that some strategy of the table sets (math.inf: closed); ``parameters`` P' by module; ``reasons`` by
    desired class; ``desires`` the strongest of each class that it answers; ``capacities`` the budgets it was found
    under.
    """

    stamp: float
    selection: Selection
    strategies: tuple[Strategy, ...]
    divisors: Mapping[str, float]
    parameters: Mapping[str, Mapping[str, Any]]
    reasons: Mapping[str, Reason]
    desires: Mapping[str, Desire]
    capacities: Mapping[str, float]


def divisors_of(strategies: Collection[Strategy], controlled: Collection[str]) -> dict[str, float]:
    """Φ': φ of each controlled filter. Where several strategies set one, the fastest wins; where none does, it
    closes."""
    divisors = dict.fromkeys(sorted(controlled), CLOSED)
    for strategy in strategies:
        for name, divisor in strategy.filters.items():
            divisors[name] = min(divisors[name], divisor)
    return divisors


def parameters_of(strategies: Collection[Strategy], desires: Mapping[str, Desire]) -> dict[str, dict[str, Any]]:
    """P': each selected strategy hands its class's desire's parameters, and its own over them, to the modules it
    concerns: its utility and its costs rest on its own.

    Where several classes concern one module, the more intense desire has the last word.
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
