"""Model predictive path integral control (Williams et al., 2017), begun from pursuits of the path.

Each cycle: (1) *proposals*: what was planned last time, moved on by the time that passed, and pure pursuits of the
way with several looks ahead and shares of its speed, driven ahead in thought as closed loops; the cheapest is kept.
(2) It is varied some hundred times with smooth noise, and the mean weighted by exp(−cost / λ) is taken. (3) The first
command is given only if the body can still stop after it; else the speed is lowered on the same curve until it can.

Costs are in seconds: progress along the way at full speed counts its time, and what is risked (nearness, speed where it
is narrow, offset from the way) is weighed against it. The noise is drawn once: equal inputs give equal commands.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.motion import Body, Choice, Field, Motion, Way

#: Different noise for so many cycles in a row.
_BANKS = 16
_KNOTS = 7


@dataclass(frozen=True, slots=True)
class MppiSettings:
    """How far is looked ahead, how often it is varied (0: not at all, pursuits alone), and what counts how much.

    ``weights``: of the offset from the path (1/m^2), of nearness, its reach (m), speed (m/s) at no clearance and its
    growth with it (1/s), of excess speed, of heading away from the path, of turning, of going back.
    """

    steps: int = 24
    step_s: float = 0.1
    rollouts: int = 480
    margin_m: float = 0.02
    temperature: float = 0.05
    sigma: tuple[float, float] = (0.25, 0.4)
    weights: tuple[float, float, float, float, float, float, float, float, float] = (
        1.0, 1.5, 0.10, 0.25, 3.0, 1.0, 0.2, 0.02, 0.5,
    )  # fmt: skip
    looks_ahead_m: tuple[float, ...] = (0.25, 0.5, 0.9)
    shares: tuple[float, ...] = (1.0, 0.6, 0.3, 0.12)
    #: A pursuit replaces what was planned last time only if it is so much (s) better: no wavering.
    loyalty: float = 0.05


class Mppi:
    """The controllers ``mppi`` and, with no variations, ``pursuit``."""

    def __init__(self, settings: MppiSettings | None = None) -> None:
        self.settings = settings or MppiSettings()
        self._plan: NDArray[np.float64] | None = None
        self._cycle = 0

    def forget(self) -> None:
        """Forget what was planned last time."""
        self._plan = None

    def choose(self, motion: Motion, field: Field, way: Way, body: Body, period_s: float) -> Choice:
        """See :class:`Controller`."""
        from app.modules.behaviors.navigation import rollouts

        s = self.settings
        scene = (field.distances, field.frame, body.outline, body.radii, body.limits, motion.state)
        costing = (s.step_s, s.margin_m, s.weights)
        best, least = np.zeros((s.steps, 2)), np.inf
        if self._plan is not None:
            best = moved_on(self._plan, period_s / s.step_s)
            least = rollouts.cost_of(*scene, way.points, way.spacing, best, *costing) - s.loyalty
        tried = np.empty((s.steps, 2))
        for share in s.shares:
            for ahead_m in s.looks_ahead_m:
                rollouts.pursue(
                    body.limits, motion.state, way.points, way.spacing, max(ahead_m, 0.4 * share * body.limits[1]),
                    share, tried, s.step_s,
                )  # fmt: skip
                cost = rollouts.cost_of(*scene, way.points, way.spacing, tried, *costing)
                if cost < least:
                    best, least = tried.copy(), cost
        if s.rollouts:
            bank = _noise(s.rollouts)[self._cycle % _BANKS]
            self._cycle += 1
            sigma = (s.sigma[0] * body.limits[1], s.sigma[1] * min(body.limits[2], 2.0))
            least = rollouts.improve(*scene, way.points, way.spacing, best, bank, sigma, *costing, s.temperature)
        self._plan = best
        return self._safe(rollouts, scene, body, best, least, motion, way, period_s)

    def _safe(self, rollouts, scene, body, plan, cost, motion, way, period_s) -> Choice:  # type: ignore[no-untyped-def]
        linear, angular = (float(value) for value in plan[0])
        clearance = rollouts.clearance_at(*scene[:4], motion.pose.x, motion.pose.y, motion.pose.theta)
        for share in (1.0, 0.7, 0.45, 0.2, 0.0):
            if rollouts.can_stop(*scene, share * linear, share * angular, period_s + 0.05, self.settings.margin_m):
                linear, angular = share * linear, share * angular
                break
        else:
            return Choice(0.0, 0.0, True, clearance)
        still = abs(linear) < 0.02 and abs(angular) < 0.05 and float(way.points[-1, 3]) > 0.1
        return Choice(linear, angular, still or share == 0.0, clearance)


def moved_on(plan: NDArray[np.float64], steps: float) -> NDArray[np.float64]:
    """``plan`` (T, 2), begun ``steps`` (a fraction, too) later; its last command is repeated at the end."""
    times = np.minimum(np.arange(len(plan)) + steps, len(plan) - 1)
    low = times.astype(np.int64)
    high = np.minimum(low + 1, len(plan) - 1)
    share = (times - low)[:, None]
    return np.asarray(plan[low] * (1 - share) + plan[high] * share)


@lru_cache(maxsize=4)
def _noise(rollouts: int) -> NDArray[np.float64]:
    random = np.random.default_rng(7)
    noise = random.standard_normal((_BANKS, rollouts, _KNOTS, 2))
    # A part of them stays near: fine steering is not found by wide throws.
    noise[:, : rollouts // 3] *= 0.3
    return noise
