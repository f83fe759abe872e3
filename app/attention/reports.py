"""What attention reports to REST, the live stream and the commands: records that are JSON as they are.

A desire and an event of the timeline are such records themselves. A record is a frozen dataclass, or a Struct where
JSON has a member ``class`` or a ``kind`` that distinguishes two records.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from msgspec import Meta, Struct

from app.attention.desires import SCALE, DesireClass
from app.attention.intention import Intention
from app.attention.strategies import Resource, Strategy, StrategyTable
from app.messages import Divisor, IntentionReport, ResourceUse, SelectedStrategy
from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class Scale:
    """The ends of the scales of desires."""

    intensity: float = SCALE
    utility: float = SCALE


@dataclass(frozen=True, slots=True)
class DesireClassReport:
    """What can be desired."""

    name: Annotated[str, Meta(examples=["FindQRCodes"])]
    title: str
    description: str
    schema: Annotated[dict[str, Any], Meta(title="JsonSchema", description="JSON Schema of `params`.")]
    served: Annotated[
        bool, doc("Whether a strategy of this program's modules serves it; else no desire for it is fulfilled.")
    ]


class StrategyReport(Struct, frozen=True, rename={"cls": "class"}):
    """One way to serve a desire class."""

    name: str
    cls: str
    utility: Annotated[float, doc("Produced utility v, over 0 and at most 8.")]
    requires: Annotated[Mapping[str, float], doc("Utility needed of other classes.")]
    filters: Annotated[Mapping[str, Divisor], doc("φ by `Module.port`.")]
    parameters: Annotated[
        Mapping[str, Mapping[str, Any]], doc("What modules are handed while it is selected, by module.")
    ]
    costs: Annotated[Mapping[str, float], doc("What it uses of each resource.")]
    selected: bool
    declared: Annotated[str | None, doc("File and line.")]


@dataclass(frozen=True, slots=True)
class ResourceReport:
    """What strategies share."""

    name: Annotated[str, Meta(examples=["cpu"])]
    capacity: Annotated[float, Meta(description="How much of it attention may give now.", examples=[120])]
    declared: Annotated[float, doc("Its capacity in configuration.")]
    used: Annotated[float, doc("What the intention at work uses of it.")]
    unit: str
    description: str


def desire_class_report(desire_class: DesireClass, table: StrategyTable) -> DesireClassReport:
    """``desire_class``, and whether ``table`` serves it."""
    return DesireClassReport(
        desire_class.name,
        desire_class.title,
        desire_class.description,
        desire_class.parameters.model_json_schema(),
        desire_class.name in table.classes,
    )


def strategy_report(strategy: Strategy, *, selected: bool) -> StrategyReport:
    """``strategy``, and whether it is at work."""
    return StrategyReport(
        strategy.name,
        strategy.cls,
        utility=strategy.utility,
        requires=strategy.requires,
        filters=strategy.filters,
        parameters=strategy.parameters,
        costs=strategy.costs,
        selected=selected,
        declared=None if strategy.location is None else str(strategy.location),
    )


def resource_report(resource: Resource, capacity: float, intention: Intention | None) -> ResourceReport:
    """``resource``, its ``capacity`` now, and what ``intention`` uses of it."""
    used = 0.0 if intention is None else intention.selection.use.get(resource.name, 0.0)
    return ResourceReport(
        resource.name,
        capacity,
        declared=resource.capacity,
        used=used,
        unit=resource.unit,
        description=resource.description,
    )


def intention_report(intention: Intention, resources: Mapping[str, Resource]) -> IntentionReport:
    """``intention``, over ``resources``."""
    selection = intention.selection
    return IntentionReport(
        stamp=intention.stamp,
        strategies=tuple(SelectedStrategy(s.name, s.cls, s.utility, s.filters, s.costs) for s in intention.strategies),
        fulfilled=selection.fulfilled,
        omega=selection.omega,
        bound=selection.bound,
        use={
            name: ResourceUse(selection.use.get(name, 0.0), capacity, resources[name].unit if name in resources else "")
            for name, capacity in intention.capacities.items()
        },
        filters=intention.divisors,
        proven=selection.proven,
        solve_ms=round(selection.solve_time_s * 1000, 3),
        relaxed=selection.relaxed,
        reasons=intention.reasons,
        parameters=intention.parameters,
        desires={cls: desire.id for cls, desire in intention.desires.items()},
    )
