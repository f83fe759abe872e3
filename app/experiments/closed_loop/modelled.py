"""A modelled computer around attention's real decisions: the same each time, in no time.

Strategies cost what is declared times a factor of their module; a competitor takes a part of the only core. What the
program wants beyond the rest waits, and is not done: messages are taken and CPU is measured in proportion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from app.attention.calibration import RESOURCE
from app.attention.capacity_governor import Pressure
from app.attention.closed_loop import ClosedLoop, Window
from app.attention.cost_estimation import Work
from app.attention.hysteresis import HysteresisState, SelectionHysteresis
from app.attention.problem import Selection, SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import CLOSED, Strategy

#: As programs have it that say nothing else.
HYSTERESIS = SelectionHysteresis(gain=2.0, dwell_s=1.0)
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
    """One window as it was: the ``selected`` strategies, ``used`` CPU of their modules, the CPU ``wanted`` and the
    ``budget`` that there was (% of the core), the ``waiting`` share, and φ by filter."""

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
        self._hold = HysteresisState(HYSTERESIS)
        self._selection = self._chosen(0.0)

    def run(self, conditions: Callable[[float], Conditions], seconds: float) -> list[Moment]:
        """Windows of ``seconds`` together, each under the ``conditions`` of its begin."""
        now, moments = 0.0, []
        while now < seconds - 1e-9:
            length = 1.0 if self._loop is None else self._loop.window_s
            moments.append(self._window(now + length, length, conditions(now)))
            now += length
        return moments

    def _window(self, now: float, length: float, conditions: Conditions) -> Moment:
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
                length,
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
        if adjustment.costs:
            strategies = tuple(
                replace(s, costs={**s.costs, RESOURCE: adjustment.costs[s.name]}) if s.name in adjustment.costs else s
                for s in self._problem.strategies
            )
            self._problem = replace(self._problem, strategies=strategies, prepared=None)
        if adjustment.share is not None:
            capacity = math.floor(1000 * self._budget * adjustment.share + 1e-6) / 1000
            self._problem = self._problem.with_capacity(RESOURCE, capacity)
        if adjustment or self._hold.until is not None:
            self._selection = self._chosen(window.now)

    def _chosen(self, now: float) -> Selection:
        problem, before = self._problem, self._problem.previous
        selection = solve(problem, time_limit_s=60.0)
        if before and self._hold.concerns(selection, before):
            only = tuple(s for s in problem.strategies if s.name in before)
            stay = solve(replace(problem, strategies=only, prepared=None), time_limit_s=60.0)
            if self._hold.holds(problem, selection, stay, before, now):
                return stay
        self._problem = replace(problem, previous=frozenset(selection.strategies))
        return selection

    def _cost(self, strategy: Strategy, conditions: Conditions) -> float:
        factors = [conditions.factors.get(module, 1.0) for module in _modules(strategy)]
        return strategy.costs.get(RESOURCE, 0.0) * max(factors, default=1.0)


def _modules(strategy: Strategy) -> list[str]:
    """Those it runs."""
    return sorted({name.partition(".")[0] for name, phi in strategy.filters.items() if phi != CLOSED})
