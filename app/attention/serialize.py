"""Attention's values as JSON, for the console and the commands alike. A closed filter's φ is null."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from app.attention.desires import Desire, DesireClass
from app.attention.intention import Intention
from app.attention.problem import Alternative, Reason, Selection
from app.attention.strategies import Resource, Strategy, StrategyTable
from app.attention.timeline import TimelineEvent
from app.attention.timeline_writer import divisor_json


def desire_to_json(desire: Desire) -> dict[str, Any]:
    """``{id, class, intensity, utility, security, params, source: {kind, name}, created, expires}``."""
    return {
        "id": desire.id,
        "class": desire.cls,
        "intensity": desire.intensity,
        "utility": desire.utility,
        "security": desire.security,
        "params": dict(desire.params),
        "source": {"kind": desire.source.kind, "name": desire.source.name},
        "created": desire.created,
        "expires": desire.expires,
    }


def desire_class_to_json(desire_class: DesireClass) -> dict[str, Any]:
    """``{name, title, description, schema}``: the schema is the JSON Schema of its parameters."""
    return {
        "name": desire_class.name,
        "title": desire_class.title,
        "description": desire_class.description,
        "schema": desire_class.parameters.model_json_schema(),
    }


def strategy_to_json(strategy: Strategy) -> dict[str, Any]:
    """``{name, class, utility, requires, filters, parameters, costs, declared}``."""
    return {
        "name": strategy.name,
        "class": strategy.cls,
        "utility": strategy.utility,
        "requires": dict(strategy.requires),
        "filters": divisors_to_json(strategy.filters),
        "parameters": {module: dict(values) for module, values in strategy.parameters.items()},
        "costs": dict(strategy.costs),
        "declared": str(strategy.location) if strategy.location is not None else None,
    }


def resource_to_json(resource: Resource) -> dict[str, Any]:
    """``{name, capacity, unit, description}``."""
    return {
        "name": resource.name,
        "capacity": resource.capacity,
        "unit": resource.unit,
        "description": resource.description,
    }


def reason_to_json(reason: Reason) -> dict[str, Any]:
    """``{state, utility, wanted, best, text, alternatives}``."""
    return {
        "state": reason.state,
        "utility": reason.utility,
        "wanted": reason.wanted,
        "best": reason.best,
        "text": reason.text,
        "alternatives": [_alternative_to_json(alternative) for alternative in reason.alternatives],
    }


def selection_to_json(
    selection: Selection,
    *,
    strategies: Collection[Strategy],
    capacities: Mapping[str, float],
    resources: Mapping[str, Resource],
    divisors: Mapping[str, float],
    reasons: Mapping[str, Reason],
) -> dict[str, Any]:
    """A selection with what it means: the selected of ``strategies``, use against ``capacities``, φ and reasons."""
    names = frozenset(selection.strategies)
    return {
        "strategies": [
            {
                "name": strategy.name,
                "class": strategy.cls,
                "utility": strategy.utility,
                "filters": divisors_to_json(strategy.filters),
                "costs": dict(strategy.costs),
            }
            for strategy in strategies
            if strategy.name in names
        ],
        "fulfilled": list(selection.fulfilled),
        "omega": selection.omega,
        "bound": selection.bound if math.isfinite(selection.bound) else None,
        "use": {
            name: {
                "used": selection.use.get(name, 0.0),
                "capacity": capacity,
                "unit": resources[name].unit if name in resources else "",
            }
            for name, capacity in capacities.items()
        },
        "filters": divisors_to_json(divisors),
        "proven": selection.proven,
        "solve_ms": round(selection.solve_time_s * 1000, 3),
        "relaxed": list(selection.relaxed),
        "reasons": {cls: reason_to_json(reason) for cls, reason in reasons.items()},
    }


def intention_to_json(intention: Intention, table: StrategyTable) -> dict[str, Any]:
    """``{stamp, strategies, fulfilled, omega, use, filters, parameters, proven, solve_ms, relaxed, reasons, …}``."""
    return {
        "stamp": intention.stamp,
        **selection_to_json(
            intention.selection,
            strategies=intention.strategies,
            capacities=intention.capacities,
            resources=table.resources,
            divisors=intention.divisors,
            reasons=intention.reasons,
        ),
        "parameters": {module: dict(values) for module, values in intention.parameters.items()},
        "desires": {cls: desire.id for cls, desire in intention.desires.items()},
    }


def event_to_json(event: TimelineEvent) -> dict[str, Any]:
    """``{id, stamp, kind, subject, text, data}``."""
    return {
        "id": event.id,
        "stamp": event.stamp,
        "kind": event.kind,
        "subject": event.subject,
        "text": event.text,
        "data": dict(event.data),
    }


def divisors_to_json(divisors: Mapping[str, float]) -> dict[str, int | None]:
    """φ by filter name."""
    return {name: divisor_json(divisor) for name, divisor in divisors.items()}


def _alternative_to_json(alternative: Alternative) -> dict[str, Any]:
    common = {"kind": alternative.kind, "utility": alternative.utility}
    if alternative.kind == "without":
        return {**common, "without": alternative.without}
    return {**common, "resource": alternative.resource, "amount": alternative.amount, "unit": alternative.unit}
