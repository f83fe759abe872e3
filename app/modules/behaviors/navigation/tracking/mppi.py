"""Model predictive path integral control (Williams et al., 2017), warm-started with pure pursuit of the path.

Each cycle: (1) *proposals*: the last cycle's controls, shifted by the elapsed time, and closed-loop rollouts of pure
pursuit with several look-ahead distances and speeds; the cheapest is kept. (2) Some hundred variations with smooth
noise are rolled out, and their mean, weighted by exp(−cost / λ), replaces it if cheaper. (3) The first command is given
only if the body can stop after it without contact; else the speed is lowered on the same arc until it can. Costs are in
seconds: progress along the path at full speed saves its time, and risk (low clearance, speed in narrow places, offset
from the path) adds to it. The noise is drawn once: equal inputs give equal commands.

Controls are linear and angular velocities. Those of a body that moves sideways have a third column, the lateral
velocity, and pursuits that strafe are among its proposals.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.controller import BodyModel, DistanceField, LocalPath, MotionState, VelocityChoice

#: Number of noise sets, used in turn by consecutive cycles.
_BANKS = 16
_KNOTS = 7
#: Shares of the best command that are tried, in order, until the body can stop after it.
_SLOWER = (1.0, 0.7, 0.45, 0.2)
#: Longest time a command may stay in force beyond its cycle, s.
_REACTION_S = 0.05


@dataclass(frozen=True, slots=True)
class MppiSettings:
    """Horizon, number of ``rollouts`` (0: pure pursuit alone), and weights.

    ``steps`` of equal length (s), chosen so that they reach ``reach_m`` at full speed, within two limits of the length.
    ``weights``: of the squared offset from the path (1/m^2), of low clearance and its range (m), the allowed share of
    the greatest speed at zero clearance and its increase per metre, of excess speed, of heading away from the path, of
    turning, of driving backward.
    """

    steps: int = 24
    least_step_s: float = 0.1
    longest_step_s: float = 0.2
    reach_m: float = 2.0
    rollouts: int = 320
    margin_m: float = 0.04
    temperature: float = 0.05
    sigma: tuple[float, float] = (0.2, 0.3)
    weights: tuple[float, float, float, float, float, float, float, float, float] = (
        0.6, 0.7, 0.10, 0.45, 1.6, 12.0, 0.2, 0.05, 0.5,
    )  # fmt: skip
    looks_ahead_m: tuple[float, ...] = (0.25, 0.5, 0.9)
    shares: tuple[float, ...] = (1.0, 0.6, 0.3, 0.12)
    asides_m: tuple[float, ...] = (0.45, 0.75)
    #: Least gain (s) for a pursuit to replace the last cycle's controls: hysteresis.
    loyalty: float = 0.02


class Mppi:
    """The controllers ``mppi`` and, without rollouts, ``pursuit``."""

    def __init__(self, settings: MppiSettings | None = None) -> None:
        self.settings = settings or MppiSettings()
        self._plan: NDArray[np.float64] | None = None
        self._cycle = 0

    def reset(self) -> None:
        """Discard the last cycle's controls."""
        self._plan = None

    def choose(
        self, motion: MotionState, field: DistanceField, way: LocalPath, body: BodyModel, period_s: float
    ) -> VelocityChoice:
        from app.modules.behaviors.navigation.tracking import rollout_kernels

        s = self.settings
        scene = (field.distances, field.frame, body.outline, body.radii, body.limits, motion.state)
        following = (way.points, way.spacing)
        # The horizon is a distance: a slow body gets a longer time.
        step_s = min(max(s.reach_m / (s.steps * body.limits[1]), s.least_step_s), s.longest_step_s)
        costing = (step_s, s.margin_m, s.weights)
        columns = 3 if body.holonomic else 2
        best, least = np.zeros((s.steps, columns)), np.inf
        if self._plan is not None:
            best = moved_on(self._plan, period_s / step_s)
            least = rollout_kernels.cost_of(*scene, *following, best, *costing) - s.loyalty
        tried = np.empty((s.steps, columns))
        for share, ahead_m, aside_m, within_m, strafing in proposals(s, strafing=body.holonomic):
            points = way.points if aside_m == 0.0 else beside(way.points, aside_m, within_m)
            ahead_m = max(ahead_m, 0.4 * share * body.limits[1])
            pursuing = (points, way.spacing, ahead_m, share, strafing)
            rollout_kernels.pursue(body.limits, motion.state, *pursuing, tried, step_s)
            cost = rollout_kernels.cost_of(*scene, *following, tried, *costing)
            if cost < least:
                best, least = tried.copy(), cost
        if s.rollouts:
            bank = _noise(s.rollouts, columns)[self._cycle % _BANKS]
            self._cycle += 1
            sigma = (s.sigma[0] * body.limits[1], s.sigma[1] * min(body.limits[2], 2.0), s.sigma[0] * body.limits[6])
            rollout_kernels.improve(*scene, *following, best, bank, sigma, *costing, s.temperature)
        self._plan = best
        # No faster than the path's limit, or than braking toward that limit.
        speed_mps = motion.speed_mps if body.holonomic else motion.linear_mps
        allowed = max(float(way.points[0, 4]), speed_mps - body.limits[5] * period_s)
        linear, angular, lateral = min(float(best[0, 0]), allowed), float(best[0, 1]), 0.0
        if body.holonomic:
            slower = min(1.0, allowed / max(math.hypot(best[0, 0], best[0, 2]), 1e-9))
            linear, lateral = slower * float(best[0, 0]), slower * float(best[0, 2])
        for share in _SLOWER:
            command = (share * linear, share * angular, share * lateral)
            if rollout_kernels.can_stop(*scene, command, period_s + _REACTION_S, s.margin_m):
                standing = abs(command[0]) < 0.02 and abs(command[1]) < 0.05 and abs(command[2]) < 0.02
                still = standing and float(way.points[-1, 3]) > 0.1
                return VelocityChoice(command[0], command[1], still, lateral_mps=command[2])
        return VelocityChoice(0.0, 0.0, True)


def proposals(settings: MppiSettings, *, strafing: bool = False) -> list[tuple[float, float, float, float, bool]]:
    """Parameters of each pursuit: share of the speed, look-ahead (m), lateral offset to the left of the path (m), the
    length (m) within which the offset is reached (around an obstacle ahead, or sideways at once out of a corner), and
    whether it strafes, which only those of ``strafing`` do."""
    ways = (False, True) if strafing else (False,)
    straight = [
        (share, ahead_m, 0.0, 1.0, sideways)
        for sideways in ways
        for share in settings.shares
        for ahead_m in settings.looks_ahead_m
    ]
    return straight + [
        (share, settings.looks_ahead_m[1], side * aside_m, within_m, False)
        for share in settings.shares[:2]
        for aside_m in settings.asides_m
        for side in (-1.0, 1.0)
        for within_m in (0.6, 0.1)
    ]


def beside(points: NDArray[np.float64], aside_m: float, within_m: float) -> NDArray[np.float64]:
    """The path ``points`` (N, 5), shifted by ``aside_m`` to its left over ``within_m``, and back at its end."""
    moved = points.copy()
    length = points[:, 3]
    offset = aside_m * np.clip(np.minimum(length / within_m, (length[-1] - length) / 0.6), 0.0, 1.0)
    moved[:, 0] -= offset * np.sin(points[:, 2])
    moved[:, 1] += offset * np.cos(points[:, 2])
    return moved


def moved_on(plan: NDArray[np.float64], steps: float) -> NDArray[np.float64]:
    """The controls ``plan`` (T, C) from ``steps`` (may be fractional) later on; the last command is repeated at the
    end."""
    times = np.minimum(np.arange(len(plan)) + steps, len(plan) - 1)
    low = times.astype(np.int64)
    high = np.minimum(low + 1, len(plan) - 1)
    share = (times - low)[:, None]
    return np.asarray(plan[low] * (1 - share) + plan[high] * share)


@lru_cache(maxsize=4)
def _noise(rollouts: int, columns: int) -> NDArray[np.float64]:
    random = np.random.default_rng(7)
    noise = random.standard_normal((_BANKS, rollouts, _KNOTS, columns))
    # Part of the noise is small: large noise finds no fine steering.
    noise[:, : rollouts // 3] *= 0.3
    return noise
