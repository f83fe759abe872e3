"""Perception on two computers: a program's own strategies, and a node that may run all that can be elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.attention.strategies import StrategyTable
from app.attention.strategy_file import load_strategies
from app.base.errors import ConfigError
from app.base.yaml_source import suggestion
from app.experiments.nodes.utility import Gain, gains
from app.program.config import Configuration, load_configuration
from app.program.nodes import streams_of
from app.remote.settings import NodeSettings
from app.remote.strategies import Elsewhere
from app.runtime.graph import load_class

#: Perceptions of the lab that take most, all of which contend for its computer.
CLASSES = ("SLAM", "FindQRCodes", "LocateFaces", "LocateVoices", "WatchSurroundings")
BUDGETS = (10.0, 15.0, 20.0, 25.0, 30.0, 36.0, 44.0)
#: Real time (s) of one selection: enough that it is proven.
TIME_LIMIT_S = 20.0


@dataclass(frozen=True, slots=True)
class NodesPlan:
    """The program's strategies, the classes desired of it, the node, the budgets (% of a core of each computer)."""

    table: StrategyTable
    classes: tuple[str, ...]
    node: Elsewhere
    budgets: tuple[float, ...]


def plan(config: Path, classes: Sequence[str], budgets: Sequence[float], *, bandwidth: float) -> NodesPlan:
    """Read everything; the costs are those of the strategies' files, not this computer's. Raises ConfigError."""
    configuration = load_configuration(config)
    table = load_strategies(
        [configuration.path(file) for file in configuration.program.strategies], classes=None, calibration=None
    )
    known = {strategy.cls for strategy in table.strategies}
    for cls in classes:
        if cls not in known:
            raise ConfigError(f"no strategy serves {cls!r}; {suggestion(cls, sorted(known))}", "--classes")
    modules = elsewhere(configuration, table)
    if not modules:
        raise ConfigError("no module of this program may run elsewhere", str(config))
    settings = NodeSettings(modules=modules, cpu=100.0, bandwidth=bandwidth)
    node = Elsewhere("desk", settings, streams_of(configuration, settings))
    return NodesPlan(table, tuple(classes), node, tuple(budgets))


def run(what: NodesPlan) -> tuple[Gain, ...]:
    """The gains, budget by budget."""
    return gains(what.table, what.classes, what.node, what.budgets, TIME_LIMIT_S)


def elsewhere(configuration: Configuration, table: StrategyTable) -> tuple[str, ...]:
    """The modules that may run elsewhere, and that a strategy has filters of."""
    used = {name.partition(".")[0] for strategy in table.strategies for name in strategy.filters}
    found = []
    for name, spec in configuration.program.modules.items():
        module_class = load_class(spec.class_path)
        if name in used and module_class is not None and module_class.runs_elsewhere:
            found.append(name)
    return tuple(found)


def document(what: NodesPlan, found: Sequence[Gain]) -> dict[str, Any]:
    """All of it, for ``--json``."""
    return {
        "classes": what.classes,
        "modules": what.node.settings.modules,
        "bandwidth_mbps": what.node.settings.bandwidth,
        "gains": [
            {
                "budget": gain.budget,
                "alone": gain.alone,
                "together": gain.together,
                "ratio": gain.ratio,
                "alone_by": gain.alone_by,
                "together_by": gain.together_by,
            }
            for gain in found
        ],
    }


def table(what: NodesPlan, found: Sequence[Gain]) -> str:
    """Markdown: a row for each budget."""
    rows = [
        "| budget of each, % | utility, one computer | two computers | times | on the other computer |",
        "| --: | --: | --: | --: | --- |",
    ]
    suffix = f"@{what.node.name}"
    for gain in found:
        there = ", ".join(name.removesuffix(suffix) for name in gain.together_by if name.endswith(suffix))
        rows.append(f"| {gain.budget:g} | {gain.alone:.1f} | {gain.together:.1f} | {gain.ratio:.2f} | {there or '–'} |")
    return "\n".join(rows)
