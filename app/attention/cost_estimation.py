"""What strategies cost, as measured while they are at work: b + s r, r the share of the messages that were worked on.

The line that calibration (thesis 4.2.3, figure 4.4: CPU is close to linear in 1/φ) or the strategies' file gives is the
prior. Each window of measured CPU moves it, by recursive least squares with a prior that is remembered: certainty fades
toward it, never beyond. Strategies that differ in φ alone are points of one line; lines whose strategies run the same
modules are estimated together, so that what one of them shows holds for the others as far as nothing speaks against it.
Bounded: no cost leaves ``most`` times, or one ``most``-th of, the prior.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.attention.calibration import RESOURCE
from app.attention.strategies import CLOSED, Strategy

#: Standard deviations of the prior, as shares of it: of all lines of the same modules alike, of one line, of base and
#: slope apart.
_ALIKE: Final = 1.0
_ONE: Final = 0.3
_APART: Final = 0.2
#: Standard deviation of a window's CPU: a share of what is expected, and % of one core.
_NOISE: Final = 0.25
_FLOOR: Final = 0.2
#: Innovations beyond so many standard deviations count as so many; the second in a row on one side is a change, and
#: what was known before it counts no more than the prior.
_SUDDEN: Final = 2.0
_CLIPPED: Final = 1.0
#: Time constants (s): of certainty, at work and otherwise; of the estimate of what is not at work, toward the prior.
_FORGETS_S: Final = 300.0
_FADES_S: Final = 600.0
#: Work below this share of what φ lets through says nothing of what it costs.
_IDLE: Final = 0.1
#: Measured modules that are as dear as declared, beside those there are, in the ratio of what was never measured.
_ORDINARY: Final = 2


@dataclass(frozen=True, slots=True)
class Work:
    """What was done in one window: CPU (% of one core) by module, and by filter ``Module.port`` of inputs the messages
    taken over those that its stream offered at its nominal rate; a filter that is not there is taken to be in time."""

    cpu: Mapping[str, float]
    taken: Mapping[str, float]


class _Line:
    """Strategies that differ in φ alone: points of one line over 1/φ of the filter that differs."""

    def __init__(self, strategies: tuple[Strategy, ...]) -> None:
        self.strategies = strategies
        first = strategies[0]
        self.modules = frozenset(name.partition(".")[0] for name, phi in first.filters.items() if phi != CLOSED)
        varying = sorted(n for n in first.filters if len({s.filters[n] for s in strategies}) > 1)
        by = varying[0] if varying else None
        self.rate = {s.name: 1.0 if by is None else _inverse(s.filters[by]) for s in strategies}
        self.declared = {s.name: s.costs[RESOURCE] for s in strategies}
        self.prior = self._fit()

    def _fit(self) -> NDArray[np.float64]:
        """Base and slope (% of one core), neither below 0, through the declared points."""
        rates = np.array([self.rate[s.name] for s in self.strategies])
        costs = np.array([self.declared[s.name] for s in self.strategies])
        if np.ptp(rates) == 0:
            return np.array([0.0, float(costs.mean() / rates.mean())]) if rates.mean() else np.array([costs.mean(), 0])
        slope, base = np.polyfit(rates, costs, 1)
        if base < 0:
            return np.array([0.0, float(rates @ costs / (rates @ rates))])
        return np.array([float(base), max(float(slope), 0.0)])

    def done(self, strategy: Strategy, taken: Mapping[str, float]) -> float:
        """The share of what φ lets through that was worked on, at most a little more than all."""
        shares = [taken[n] * phi for n, phi in strategy.filters.items() if n in taken and phi != CLOSED]
        return min(1.25, sum(shares) / len(shares)) if shares else 1.0


class _Group:
    """Lines whose strategies run the same modules: one estimate of all of their bases and slopes."""

    def __init__(self, lines: list[_Line]) -> None:
        self.lines = lines
        self.modules = frozenset().union(*(line.modules for line in lines))
        self.prior = np.concatenate([line.prior for line in lines])
        own = np.zeros((len(self.prior), len(self.prior)))
        for place, line in enumerate(lines):
            at = slice(2 * place, 2 * place + 2)
            own[at, at] = np.outer(line.prior, line.prior)
        typical = np.repeat([line.prior.sum() for line in lines], 2)
        self._uncertain = _ALIKE**2 * np.outer(self.prior, self.prior) + _ONE**2 * own + _APART**2 * np.diag(typical**2)
        self.theta = self.prior.copy()
        self._covariance = self._uncertain.copy()
        self._side = 0
        #: The last window's CPU, % of one core, and the share of each strategy at work in it; None and nothing without.
        self.measured: float | None = None
        self.parts: dict[str, float] = {}
        #: Whether it was measured at all, and whether it had nothing to do in the last window.
        self.seen = False
        self.idle = True

    def take(self, at_work: Collection[str], work: Work, dt: float) -> None:
        """One window of ``dt`` s with the strategies ``at_work``."""
        row = np.zeros(len(self.prior))
        modules: set[str] = set()
        done = 0.0
        self.parts = {}
        for place, line in enumerate(self.lines):
            for strategy in line.strategies:
                if strategy.name in at_work:
                    share = line.done(strategy, work.taken)
                    mine = np.array((1.0, line.rate[strategy.name] * share))
                    row[2 * place : 2 * place + 2] += mine
                    self.parts[strategy.name] = float(mine @ self.theta[2 * place : 2 * place + 2])
                    modules |= line.modules
                    done = max(done, share)
        self.idle = not modules
        if self.idle:
            self.measured = None
            return
        self.measured = sum(work.cpu.get(name, 0.0) for name in modules)
        whole = sum(self.parts.values())
        even = 1 / len(self.parts)
        self.parts = {n: self.measured * (part / whole if whole else even) for n, part in self.parts.items()}
        if done >= _IDLE:
            self._forget(dt, _FORGETS_S)
            self._update(row, self.measured)

    def has(self, names: Collection[str]) -> bool:
        """Whether strategies of it are among ``names``."""
        return any(name in line.declared for line in self.lines for name in names)

    def skip(self) -> None:
        """A window that says nothing."""
        self.measured, self.parts, self._side = None, {}, 0
        self.idle = False

    def fade(self, dt: float, toward: float) -> None:
        """``dt`` s without work: the estimate goes toward ``toward`` times the prior."""
        self._side = 0
        self._forget(dt, _FADES_S)
        self.theta += (1 - math.exp(-dt / _FADES_S)) * (toward * self.prior - self.theta)

    @property
    def suspects(self) -> bool:
        """Whether the last window was so unlike the estimate that another such one is a change."""
        return self._side != 0

    @property
    def ratio(self) -> float:
        """The estimate over the prior, by the sums of both."""
        return float(self.theta.sum() / self.prior.sum())

    def _forget(self, dt: float, time_constant: float) -> None:
        self._covariance += (1 - math.exp(-dt / time_constant)) * (self._uncertain - self._covariance)

    def _update(self, row: NDArray[np.float64], measured: float) -> None:
        expected = float(row @ self.theta)
        innovation = measured - expected
        noise = (_NOISE * min(expected, measured)) ** 2 + _FLOOR**2
        deviation = math.sqrt(float(row @ self._covariance @ row) + noise)
        if abs(innovation) > _SUDDEN * deviation:
            side = 1 if innovation > 0 else -1
            if side == self._side:
                self._covariance, self._side = self._uncertain.copy(), 0
            else:
                self._side, innovation = side, side * _CLIPPED * deviation
        else:
            self._side = 0
        gain = self._covariance @ row / (float(row @ self._covariance @ row) + noise)
        self.theta = np.maximum(self.theta + gain * innovation, 0.0)
        self._covariance -= np.outer(gain, row @ self._covariance)
        self.seen = True


class CostEstimator:
    """Estimates what each of ``strategies`` costs of the CPU; those declared free stay free."""

    def __init__(self, strategies: Iterable[Strategy], most: float) -> None:
        """``most``: the most that an estimate may be of the prior; its inverse is the least. Raises ValueError below
        1."""
        if most < 1:
            raise ValueError(f"costs are bounded by a factor of at least 1, not {most!r}")
        self._most = most
        self._groups = [_Group(lines) for lines in _by_modules(_lines(strategies))]

    def take(self, at_work: Collection[str], work: Work, dt: float, unsettled: Collection[str] = ()) -> None:
        """A window of ``dt`` s closed, in which the strategies ``at_work`` were selected all the time; where some are
        ``unsettled``, which were for a part of it, it says nothing."""
        for group in self._groups:
            if group.has(unsettled):
                group.skip()
            else:
                group.take(at_work, work, dt)
        unseen = self._unseen_ratio()
        for group in self._groups:
            if not group.seen:
                group.theta = unseen * group.prior
            elif group.idle:
                group.fade(dt, 1.0)

    def costs(self) -> dict[str, float]:
        """The estimate of each strategy (% of one core at the φ it sets), by name."""
        found = {}
        for group in self._groups:
            for place, line in enumerate(group.lines):
                theta = group.theta[2 * place : 2 * place + 2]
                for name, declared in line.declared.items():
                    row = np.array([1.0, line.rate[name]])
                    expected = float(row @ line.prior)
                    ratio = float(row @ theta) / expected if expected > 0 else 1.0
                    found[name] = declared * min(max(ratio, 1 / self._most), self._most)
        return found

    def measured(self) -> dict[str, float]:
        """The last window's CPU of those at work, by name: where several share modules, in proportion to the
        estimates."""
        return {name: part for group in self._groups for name, part in group.parts.items()}

    def groups(self) -> tuple[frozenset[str], ...]:
        """The strategies that are estimated together, by name."""
        return tuple(frozenset(n for line in group.lines for n in line.declared) for group in self._groups)

    @property
    def suspects(self) -> bool:
        """Whether some of them may just have changed."""
        return any(group.suspects for group in self._groups)

    def used(self) -> float:
        """The last window's CPU of all modules at work for strategies, % of one core."""
        return sum(group.measured for group in self._groups if group.measured is not None)

    def _unseen_ratio(self) -> float:
        """How dear this computer is beside what was declared, by the modules that were measured. Not below 1: many have
        nothing to do most of the time, which makes no other module cheap."""
        return max(1.0, median([1.0] * _ORDINARY + [group.ratio for group in self._groups if group.seen]))


def _inverse(phi: float) -> float:
    return 0.0 if phi == CLOSED else 1.0 / phi


def _lines(strategies: Iterable[Strategy]) -> list[_Line]:
    kinds: dict[object, list[Strategy]] = {}
    for strategy in strategies:
        opens = any(phi != CLOSED for phi in strategy.filters.values())
        if opens and strategy.costs.get(RESOURCE, 0.0) > 0:
            closed = frozenset(n for n, phi in strategy.filters.items() if phi == CLOSED)
            handed = repr(sorted((m, sorted(v.items(), key=str)) for m, v in strategy.parameters.items()))
            kinds.setdefault((strategy.cls, frozenset(strategy.filters), closed, handed), []).append(strategy)
    return [_Line(tuple(members)) for members in kinds.values()]


def _by_modules(lines: Iterable[_Line]) -> list[list[_Line]]:
    """Lines in groups that have no module in common."""
    groups: list[tuple[set[str], list[_Line]]] = []
    for line in lines:
        mine = [group for group in groups if not group[0].isdisjoint(line.modules)]
        modules = set(line.modules).union(*(group[0] for group in mine))
        merged = [each for group in mine for each in group[1]]
        groups = [group for group in groups if not any(group is each for each in mine)]
        groups.append((modules, [*merged, line]))
    return [group[1] for group in groups]
