"""What a second computer is worth: utility that attention gets out of one computer, and out of two of the same budget.

Pure: the solver on the program's own strategies, and on those with the other computer's beside them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.attention.calibration import RESOURCE as CPU
from app.attention.problem import SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import StrategyTable
from app.messages import Desire, Source
from app.remote.strategies import Elsewhere, with_nodes

#: All desires are as strong: the solver then maximizes the sum of what strategies produce.
INTENSITY = 5.0


@dataclass(frozen=True, slots=True)
class Gain:
    """What the classes desired get at one ``budget`` (% of a core, of each computer), and by which strategies."""

    budget: float
    alone: float
    together: float
    alone_by: tuple[str, ...]
    together_by: tuple[str, ...]

    @property
    def ratio(self) -> float:
        """Times as much utility on two computers; infinite where one alone gives none."""
        return self.together / self.alone if self.alone else float("inf")


def gains(
    table: StrategyTable, classes: Sequence[str], node: Elsewhere, budgets: Sequence[float], time_limit_s: float
) -> tuple[Gain, ...]:
    """For each of ``budgets``: ``classes`` all desired at once, on the robot alone and with ``node`` beside it.

    Both computers have the budget as their CPU. Raises SolverFailed where a problem has no answer in time.
    """
    desires = {cls: _desire(cls) for cls in classes}
    found = []
    for budget in budgets:
        equal = replace(node, settings=node.settings.model_copy(update={"cpu": budget}))
        alone = _selected(table, desires, {CPU: budget}, time_limit_s)
        together = _selected(with_nodes(table, [equal]), desires, {CPU: budget, node.cpu: budget}, time_limit_s)
        found.append(Gain(budget, alone[0], together[0], alone[1], together[1]))
    return tuple(found)


def _selected(
    table: StrategyTable, desires: dict[str, Desire], capacities: dict[str, float], time_limit_s: float
) -> tuple[float, tuple[str, ...]]:
    problem = SelectionProblem(desires, table.strategies, {**table.capacities(), **capacities})
    names = solve(problem, time_limit_s=time_limit_s).strategies
    return sum(table[name].utility for name in names if table[name].cls in desires), names


def _desire(cls: str) -> Desire:
    source = Source("operator", "the experiment")
    return Desire(
        id=cls, cls=cls, intensity=INTENSITY, utility=1.0, security=False, params={}, source=source, created=0.0
    )
