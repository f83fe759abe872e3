"""What ``hbba calibrate`` tells at its end: the relations it measured, and what strategies cost by them."""

from __future__ import annotations

from collections.abc import Mapping, Set

from app.attention.calibration import RESOURCE, Calibration, relation_name
from app.attention.strategies import CLOSED, Strategy, StrategyTable
from app.runtime.graph import ModuleSpec


def relations_table(calibration: Calibration, measured: Set[str]) -> str:
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
    declared: StrategyTable, calibration: Calibration, measured: Set[str], modules: Mapping[str, ModuleSpec]
) -> str:
    """What each strategy that uses one of ``measured`` costs: as ``declared``, loaded without a calibration, and by
    ``calibration``; "" where there is none.

    An input that was not measured (its channel is not in the recording) is named: the measured cost is without it.
    """
    rows = []
    for strategy in declared.strategies:
        wanted = _relations(strategy, modules)
        cost = calibration.cost(strategy.filters, strategy.parameters)
        if cost is None or not measured & set(wanted.values()):
            continue
        lacking = [name for name, relation in wanted.items() if relation not in calibration.relations]
        without = f"   (without {', '.join(lacking)})" if lacking else ""
        rows.append((strategy.name, strategy.costs.get(RESOURCE, 0.0), cost, without))
    if not rows:
        return ""
    width = max(len("strategy"), *(len(name) for name, *_ in rows))
    lines = [f"\n{'strategy':{width}}  declared  measured   ({RESOURCE}, % of one core)"]
    lines += [f"{name:{width}}  {before:8.2f}  {after:8.2f}{without}" for name, before, after, without in rows]
    return "\n".join(lines)


def _relations(strategy: Strategy, modules: Mapping[str, ModuleSpec]) -> dict[str, str]:
    """The relations that its cost should be the sum of, by filter: those of its inputs (an output costs nothing)."""
    found = {}
    for name, phi in strategy.filters.items():
        module, _, port = name.partition(".")
        if phi != CLOSED and module in modules and port in modules[module].inputs:
            found[name] = relation_name(name, strategy.parameters.get(module, {}))
    return found
