"""Attention put together from its configuration: the strategies, the filters that they are given, the translator.

Each function raises ConfigError, with file and line, for what cannot be.
"""

from __future__ import annotations

from dataclasses import replace

from app.attention.cached_solver import CachedSolver
from app.attention.desires import DesireClasses
from app.attention.explaining import EXPLAIN_S
from app.attention.hysteresis import SelectionHysteresis
from app.attention.problem import Weights
from app.attention.strategies import StrategyTable, trimmed
from app.attention.strategy_file import load_strategies
from app.attention.timeline import Timeline
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.base.yaml_source import suggestion
from app.program.config import Configuration, PowerConfig
from app.program.nodes import ProgramNodes
from app.runtime.clock import Clock
from app.runtime.filter import CLOSED
from app.runtime.graph import Graph
from app.runtime.module import Caution

#: Real seconds for the solver and for reasons where nothing may depend on how fast this computer is.
_PATIENT_S = 60.0


def load_table(
    configuration: Configuration,
    graph: Graph,
    classes: DesireClasses,
    *,
    nodes: ProgramNodes | None = None,
    partial: bool = False,
) -> StrategyTable:
    """The strategies of the configuration's files, with those of ``nodes``; ``partial``: modules that ``graph`` lacks
    are left out of them."""
    table = load_strategies(
        [configuration.path(file) for file in configuration.program.strategies],
        classes=classes,
        ports=None if partial else graph.ports(),
        undivided=graph.filters.undivided(),
        calibration=configuration.calibration,
    )
    table = trimmed(table, graph.ports()) if partial else table
    return table if nodes is None else nodes.extend(table)


def attend(configuration: Configuration, graph: Graph, table: StrategyTable) -> tuple[Caution, ...]:
    """Hand filters over to attention, and with them every output that can move the body: one that no strategy opens
    stays closed. Returns what people must know of that, and of the modules."""
    moving = graph.moving()
    graph.attend(table.filters | moving.keys())
    opened = {name for each in table.strategies for name, phi in each.filters.items() if phi != CLOSED}
    cautions = []
    for name, slot in graph.modules.items():
        where = configuration.where("modules", name)
        cautions += [replace(caution, where=where) for caution in slot.module.cautions()]
    for output in sorted(moving.keys() - opened):
        module, port = output.split(".", 1)
        text = (
            f"no strategy opens {output}, which leads to {moving[output]} and can move the robot: it stays closed; "
            "name it in `filters` of a strategy, and the file of that strategy in `strategies` of the program"
        )
        where = configuration.where("modules", module, "outputs", port)
        cautions.append(Caution(f"{graph.modules[module].title} stays closed", text, where))
    return tuple(cautions)


def unserved(
    configuration: Configuration, graph: Graph, table: StrategyTable, classes: DesireClasses
) -> tuple[Caution, ...]:
    """A warning for each of ``classes`` that no strategy of ``table`` serves and a module here declares: a desire of it
    does nothing."""
    cautions = []
    for cls in sorted(set(classes) - {each.cls for each in table.strategies}):
        modules = [name for name, slot in graph.modules.items() if classes[cls] in slot.module.desire_classes]
        if not modules:  # those of a replay or a trial are not all there
            continue
        text = (
            f"no strategy serves {cls}, a class of {' and '.join(modules)}: a desire of it does nothing; add one to a "
            "file under `strategies` of the program, and the module whose filters it opens"
        )
        where = configuration.where("modules", modules[0])
        cautions.append(Caution(f"{classes[cls].title} is served by nothing", text, where))
    return tuple(cautions)


def power_budget(configuration: Configuration, table: StrategyTable) -> PowerConfig | None:
    """How power is budgeted; None where it is not."""
    power = configuration.program.attention.power
    if power is None or power.resource in table.resources:
        return power
    message = f"there is no resource {power.resource!r}; {suggestion(power.resource, list(table.resources))}"
    raise configuration.program_document.error(message, ("attention", "power", "resource"))


def make_translator(
    configuration: Configuration,
    graph: Graph,
    table: StrategyTable,
    *,
    workspace: IntentionWorkspace,
    timeline: Timeline,
    clock: Clock,
    power: PowerConfig | None = None,
    partial: bool = False,
    reproducible: bool = False,
) -> IntentionTranslator:
    """The translator of ``table`` for the filters of ``graph``. ``partial``: safe strategies that there are not are
    left out; ``reproducible``: what it answers does not depend on the speed of this computer."""
    settings = configuration.program.attention
    safe = settings.safe_strategies
    if partial:
        there = {strategy.name for strategy in table.strategies}
        safe = tuple(name for name in safe if name in there)
    limit_s = _PATIENT_S if reproducible else settings.solve_time_limit_s
    try:
        return IntentionTranslator(
            workspace,
            table,
            filters=graph.filters,
            parameters=graph,
            timeline=timeline,
            clock=clock,
            safe=safe,
            solver=CachedSolver(time_limit_s=limit_s, timed=not reproducible),
            explain_limit_s=_PATIENT_S if reproducible else EXPLAIN_S,
            weights=Weights(
                settings.weights.intensity,
                settings.weights.utility,
                spare=0.0 if power is None else power.weight,
                spare_of="" if power is None else power.resource,
            ),
            hysteresis=SelectionHysteresis(settings.hysteresis_gain, settings.hysteresis_dwell_s),
        )
    except ValueError as failure:
        raise configuration.program_document.error(str(failure), ("attention", "safe_strategies")) from None
