"""What attention reports to REST, the live stream and the commands: records of :mod:`app.messages.attention`."""

from __future__ import annotations

from collections.abc import Mapping

from app.attention.desires import DesireClass
from app.attention.intention import Intention
from app.attention.strategies import Resource, Strategy, StrategyTable
from app.attention.workspace import IntentionWorkspace
from app.messages import (
    Asked,
    ChangedStrategy,
    DesireClassReport,
    DesireProgress,
    Desires,
    IntentionReport,
    OmegaWeights,
    ResourceReport,
    ResourceUse,
    SelectedStrategy,
    StrategyReport,
)

#: Desires that left, in the list of desires.
ENDED_SHOWN = 5


def desire_class_report(desire_class: DesireClass, table: StrategyTable) -> DesireClassReport:
    """``desire_class``, and whether ``table`` serves it."""
    return DesireClassReport(
        desire_class.name,
        desire_class.title,
        desire_class.description,
        desire_class.parameters.model_json_schema(),
        served=desire_class.name in table.classes,
        achievement=desire_class.achievement,
    )


def desires_report(
    workspace: IntentionWorkspace,
    now: float,
    exploited: tuple[str, ...],
    progress: tuple[DesireProgress, ...] = (),
) -> Desires:
    """The desires there are at ``now``, their ``progress``, and the last that left; ``exploited`` are ids."""
    return Desires(
        now,
        workspace.desires(),
        exploited,
        accomplishments=workspace.accomplishments(),
        ended=workspace.ended(ENDED_SHOWN),
        progress=progress,
    )


def strategy_report(strategy: Strategy, declared: Strategy, *, selected: bool) -> StrategyReport:
    """``strategy`` as attention reckons with it, as it was ``declared``, and whether it is at work."""
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
        declared_costs=declared.costs,
        declared_utility=declared.utility,
    )


def resource_report(resource: Resource, capacity: float, budget: float, intention: Intention | None) -> ResourceReport:
    """``resource``, its ``capacity`` now, of the ``budget`` set, and what ``intention`` uses of it."""
    used = 0.0 if intention is None else intention.selection.use.get(resource.name, 0.0)
    return ResourceReport(
        resource.name,
        capacity,
        declared=resource.capacity,
        used=used,
        budget=budget,
        unit=resource.unit,
        description=resource.description,
    )


def intention_report(intention: Intention, resources: Mapping[str, Resource]) -> IntentionReport:
    """``intention``, over ``resources``."""
    selection, weights = intention.selection, intention.weights
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
        asked={cls: Asked(d.intensity, d.utility, d.security, d.modulation) for cls, d in intention.desires.items()},
        previous=tuple(sorted(intention.previous)),
        changed=tuple(ChangedStrategy(s.name, s.utility, s.costs) for s in intention.changed),
        weights=OmegaWeights(weights.intensity, weights.utility, spare=weights.spare, spare_of=weights.spare_of),
    )
