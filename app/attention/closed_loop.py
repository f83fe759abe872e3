"""The closed loop of attention: costs follow what is measured, the budget of the CPU follows the computer's pressure.

Pure: :meth:`ClosedLoop.take` takes what one window measured and gives what the problem should be from now on. What is
dearer than reckoned counts as soon as the budget is exceeded; what is cheaper counts when that has lasted, the longer
the more often it had to be taken back; what changes little changes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

from app.attention.calibration import RESOURCE
from app.attention.capacity_governor import CapacityGovernor, Pressure
from app.attention.cost_estimation import CostEstimator, Work
from app.attention.desires import GRAIN
from app.attention.reluctance import Reluctance
from app.attention.strategies import Strategy

#: Lengths of windows (s): while all goes on as before, and after something changed, for so many windows.
WINDOW_S: Final = 1.0
SHORT_S: Final = 0.5
_AFTER: Final = 6
#: A new estimate is used where it differs from the one in use by this share, and by this much (% of one core).
_DIFFERS: Final = 0.15
_LEAST: Final = 0.3
#: More than this share of the budget, by the estimates, is too much.
_EXCEEDED: Final = 1.05


@dataclass(frozen=True, slots=True)
class LoopLimits:
    """Bounds: ``most`` an estimate may be of what is declared, and its inverse the least; ``least_share`` of the budget
    that pressure leaves."""

    most: float = 5.0
    least_share: float = 0.5


@dataclass(frozen=True, slots=True)
class Window:
    """What was measured in the ``length_s`` s before ``now``, with the strategies ``at_work`` all that time and those
    ``unsettled`` for a part of it; ``budget`` as people set it, % of one core."""

    now: float
    length_s: float
    at_work: Collection[str]
    work: Work
    pressure: Pressure
    budget: float
    unsettled: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class Adjustment:
    """What changes: costs of the CPU by strategy, the share of its budget; nothing where empty and None. ``why`` in
    words, with the strategies at work that matter."""

    costs: Mapping[str, float] = field(default_factory=dict)
    share: float | None = None
    why: str = ""

    def __bool__(self) -> bool:
        return bool(self.costs) or self.share is not None


@dataclass(frozen=True, slots=True)
class CostNow:
    """A strategy's CPU, % of one core: ``declared`` (calibrated, where it is), ``measured`` in the last window (None:
    not at work), ``estimated``, and ``used`` by attention."""

    declared: float
    measured: float | None
    estimated: float
    used: float


class ClosedLoop:
    """Keeps what attention reckons with close to what is."""

    def __init__(self, strategies: Collection[Strategy], limits: LoopLimits | None = None) -> None:
        """Raises ValueError for limits that cannot be."""
        limits = limits or LoopLimits()
        self._estimator = CostEstimator(strategies, limits.most)
        self._governor = CapacityGovernor(limits.least_share)
        self._declared = {s.name: s.costs.get(RESOURCE, 0.0) for s in strategies}
        self._used = dict(self._declared)
        self._groups = [(group, Reluctance()) for group in self._estimator.groups()]
        self._measured: Mapping[str, float] = {}
        self._windows_since = 0

    @property
    def share(self) -> float:
        """Of the budget, what may be given now."""
        return self._governor.share

    @property
    def window_s(self) -> float:
        """How long the next window should be: short where the last one made something change, or may be about to."""
        short = self._estimator.suspects or self._governor.suspects or self._windows_since < _AFTER
        return SHORT_S if short else WINDOW_S

    @property
    def measured_cpu(self) -> float:
        """The last window's CPU of all modules at work for strategies, % of one core."""
        return self._estimator.used()

    def costs(self) -> dict[str, CostNow]:
        """By strategy, of those whose CPU is estimated."""
        estimated = self._estimator.costs()
        return {
            name: CostNow(self._declared[name], self._measured.get(name), cost, self._used[name])
            for name, cost in estimated.items()
        }

    def take(self, window: Window) -> Adjustment:
        """What changes after ``window``."""
        self._estimator.take(window.at_work, window.work, window.length_s, window.unsettled)
        self._measured = self._estimator.measured()
        used = self._estimator.used()
        moved = self._governor.take(window.now, window.pressure, window.budget, used)
        changed = self._changed(window)
        self._used |= changed
        share = self._governor.share if moved else None
        self._windows_since = 0 if changed or moved else self._windows_since + 1
        return Adjustment(changed, share, self._words(window, changed, share))

    def _changed(self, window: Window) -> dict[str, float]:
        estimated = self._estimator.costs()
        budget = window.budget * self._governor.share
        at_work = sum(estimated.get(name, 0.0) for name in window.at_work)
        exceeded = at_work > _EXCEEDED * budget
        changed: dict[str, float] = {}
        for group, reluctance in self._groups:
            # What is at work says how the group stands; where none is, its dearest does.
            judged = [name for name in group if name in window.at_work] or [max(group, key=self._declared.__getitem__)]
            is_, was = (sum(costs[name] for name in judged) for costs in (estimated, self._used))
            dearer = is_ > was and (differs(is_, was) or (exceeded and is_ > was + _LEAST))
            cheaper = is_ < was and differs(is_, was)
            if reluctance.want(window.now, cheaper):
                reluctance.give(window.now)
            elif not dearer:
                continue
            else:
                reluctance.take_back(window.now)
            changed |= {name: _grained(estimated[name]) for name in group}
        return {name: cost for name, cost in changed.items() if cost != self._used[name]}

    def _words(self, window: Window, changed: Mapping[str, float], share: float | None) -> str:
        said = []
        if share is not None:
            lack = window.pressure.lack
            cause = f"the program's threads lacked {100 * lack:.0f} % of their time"
            if window.pressure.has_room:
                cause = f"its cores have {window.pressure.room:.0f} % of a core free"
            said.append(cause)
        named = sorted(name for name in changed if name in self._measured)
        if named:
            figures = (f"{name} {changed[name]:.1f} % ({self._declared[name]:g} % declared)" for name in named)
            said.append(f"measured: {', '.join(figures)}")
        return "; ".join(said)


def differs(one: float, other: float) -> bool:
    """Whether two costs (% of one core) differ by enough to matter."""
    return abs(one - other) > max(_LEAST, _DIFFERS * max(one, other))


def _grained(cost: float) -> float:
    return math.ceil(cost * GRAIN - 1e-6) / GRAIN
