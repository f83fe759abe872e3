"""The report of ``hbba calibrate``: the relations it measured, and the costs of strategies by them."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Any

from app.attention.calibration import RESOURCE, CostCalibration, relation_name
from app.attention.strategies import CLOSED, Strategy, StrategyTable
from app.runtime.graph import ModuleSpec


def relations_table(calibration: CostCalibration, measured: Set[str]) -> str:
    """The relations for people; those that were not ``measured`` now are named as kept."""
    lines = []
    for name, relation in calibration.relations.items():
        lines.append(f"\n{name}" + ("" if name in measured else " (measured before, kept)"))
        lines.append("    φ    CPU %   spread   events/s   runs")
        lines += [
            f"{p.phi:5d}  {p.cpu:7.2f}  {p.cpu_spread:7.2f}  {p.events:9.2f}  {p.runs:5d}" for p in relation.points
        ]
        for what, line in (("CPU %", relation.cpu), ("events/s", relation.events)):
            lines.append(f"  {what} = {line.base:.3g} + {line.slope:.3g}/φ, residual {line.residual:.2g}")
        if not any(p.events for p in relation.points):
            lines.append("  (the recording holds nothing that this module finds)")
    return "\n".join(lines)


def strategies_table(
    declared: StrategyTable, calibration: CostCalibration, measured: Set[str], modules: Mapping[str, ModuleSpec]
) -> str:
    """The cost of each strategy that uses one of ``measured``: as ``declared``, loaded without a calibration, and by
    ``calibration``; "" where there is none.

    An input that was not measured (its channel is not in the recording) is named: the measured cost does not include
    it.
    """
    rows = strategies_document(declared, calibration, measured, modules)
    if not rows:
        return ""
    width = max(len("strategy"), *(len(row["name"]) for row in rows))
    lines = [f"\n{'strategy':{width}}  declared  measured   ({RESOURCE}, % of one core)"]
    for row in rows:
        without = f"   (without {', '.join(row['without'])})" if row["without"] else ""
        lines.append(f"{row['name']:{width}}  {row['declared']:8.2f}  {row['measured']:8.2f}{without}")
    return "\n".join(lines)


def strategies_document(
    declared: StrategyTable, calibration: CostCalibration, measured: Set[str], modules: Mapping[str, ModuleSpec]
) -> list[dict[str, Any]]:
    """The same for programs, costs in % of one core: ``name``, ``declared``, ``measured``, and the inputs that the
    measured cost is ``without``."""
    rows = []
    for strategy in declared.strategies:
        wanted = _relations(strategy, modules)
        cost = calibration.cost(strategy.filters, strategy.parameters)
        if cost is None or not measured & set(wanted.values()):
            continue
        lacking = [name for name, relation in wanted.items() if relation not in calibration.relations]
        before = strategy.costs.get(RESOURCE, 0.0)
        rows.append({"name": strategy.name, "declared": before, "measured": cost, "without": lacking})
    return rows


def _relations(strategy: Strategy, modules: Mapping[str, ModuleSpec]) -> dict[str, str]:
    """The relations that its cost should be the sum of, by filter: those of its inputs (an output costs nothing)."""
    found = {}
    for name, phi in strategy.filters.items():
        module, _, port = name.partition(".")
        if phi != CLOSED and module in modules and port in modules[module].inputs:
            found[name] = relation_name(name, strategy.parameters.get(module, {}))
    return found
