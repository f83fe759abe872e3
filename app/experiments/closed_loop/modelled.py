"""A modelled computer around attention's real decisions: the same each time, in no time.

Strategies cost what is declared times a factor of their module; a competitor takes a part of the only core. What the
program wants beyond the rest waits, and is not done: messages are taken and CPU is measured in proportion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from app.attention.calibration import RESOURCE
from app.attention.capacity_governor import Pressure
from app.attention.closed_loop import ClosedLoop, Window
from app.attention.cost_estimation import Work
from app.attention.problem import Selection, SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import CLOSED, Strategy

#: Waiting of threads for each other, which nobody causes.
_EACH_OTHER = 0.05


@dataclass(frozen=True, slots=True)
class Conditions:
    """The computer in one window: ``factors`` by module of what is declared, 1 where nothing is said; ``taken`` of the
    core (%) by a competitor that runs whenever it can; ``noise`` of each module's CPU, as a factor."""

    factors: Mapping[str, float] = field(default_factory=dict)
    taken: float = 0.0
    noise: Callable[[str], float] = lambda module: 1.0


@dataclass(frozen=True, slots=True)
class Moment:
    """One window as it was: the ``selected`` strategies, ``used`` CPU of their modules and the ``budget`` that there was
    for it (% of the core), the ``waiting`` share, and φ by filter."""

    now: float
    selected: tuple[str, ...]
    used: float
    wanted: float
    budget: float
    waiting: float
    divisors: Mapping[str, float]


class ModelledRobot:
    """Attention over ``problem`` on a modelled core, window by window; without ``loop``, it is open."""

    def __init__(self, problem: SelectionProblem, loop: ClosedLoop | None, own: float = 20.0) -> None:
        """``own``: what the program takes of the core beside its strategies, %."""
        self._declared = {s.name: s for s in problem.strategies}
        self._problem = problem
        self._budget = problem.capacities[RESOURCE]
        self._loop = loop
        self._own = own
        self._selection = self._solve()
        self._before: frozenset[str] = frozenset()

    def run(self, conditions: Sequence[Conditions], began: float = 0.0) -> list[Moment]:
        """One window of a second under each of ``conditions``."""
        return [self._window(began + number + 1, each) for number, each in enumerate(conditions)]

    def _window(self, now: float, conditions: Conditions) -> Moment:
        chosen = frozenset(self._selection.strategies)
        wanted = {name: self._cost(self._declared[name], conditions) for name in chosen}
        demand = self._own + sum(wanted.values())
        there = 100.0 - conditions.taken
        done = min(1.0, there / demand)
        cpu: dict[str, float] = {}
        taken: dict[str, float] = {}
        for name in chosen:
            strategy = self._declared[name]
            for first in _modules(strategy)[:1]:
                cpu[first] = cpu.get(first, 0.0) + done * wanted[name] * conditions.noise(first)
            taken |= {f: done / phi for f, phi in strategy.filters.items() if phi != CLOSED}
        pressure = Pressure(
            # What wants more than there is always could run, and runs when it is its turn.
            waiting=_EACH_OTHER if done == 1 else max(_EACH_OTHER, 1 - done, conditions.taken / 100),
            room=0.0 if conditions.taken else max(0.0, there - demand),
        )
        used, capacity = sum(cpu.values()), self._problem.capacities[RESOURCE]
        moment = Moment(
            now,
            self._selection.strategies,
            used=used,
            wanted=sum(wanted.values()),
            budget=capacity,
            waiting=pressure.waiting,
            divisors={f: phi for name in chosen for f, phi in self._declared[name].filters.items()},
        )
        if self._loop is not None:
            window = Window(
                now,
                1.0,
                at_work=chosen,
                work=Work(cpu, taken),
                pressure=pressure,
                budget=self._budget,
            )
            self._adjust(window)
        return moment

    def _adjust(self, window: Window) -> None:
        assert self._loop is not None
        adjustment = self._loop.take(window)
        if not adjustment:
            return
        if adjustment.costs:
            strategies = tuple(
                replace(s, costs={**s.costs, RESOURCE: adjustment.costs[s.name]}) if s.name in adjustment.costs else s
                for s in self._problem.strategies
            )
            self._problem = replace(self._problem, strategies=strategies, prepared=None)
        if adjustment.share is not None:
            capacity = math.floor(1000 * self._budget * adjustment.share + 1e-6) / 1000
            self._problem = self._problem.with_capacity(RESOURCE, capacity)
        self._selection = self._solve()

    def _solve(self) -> Selection:
        selection = solve(self._problem, time_limit_s=60.0)
        self._problem = replace(self._problem, previous=frozenset(selection.strategies))
        return selection

    def _cost(self, strategy: Strategy, conditions: Conditions) -> float:
        factors = [conditions.factors.get(module, 1.0) for module in _modules(strategy)]
        return strategy.costs.get(RESOURCE, 0.0) * max(factors, default=1.0)


def _modules(strategy: Strategy) -> list[str]:
    """Those it runs."""
    return sorted({name.partition(".")[0] for name, phi in strategy.filters.items() if phi != CLOSED})
