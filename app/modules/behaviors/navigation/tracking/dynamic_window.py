"""The Dynamic Window Approach (Fox, Burgard and Thrun, 1997; thesis 4.2).

Velocities reachable within one period are sampled and rolled out as arcs. Velocities from which the body could not stop
before an obstacle are rejected; among the others the one of least cost is chosen::

    cost = a · distance from the path + b · distance to the local goal + c / clearance + d · (v_max − v)

The local goal is the path's point ``ahead_m`` ahead.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.modules.behaviors.navigation.controller import BodyModel, DistanceField, LocalPath, MotionState, VelocityChoice


@dataclass(frozen=True, slots=True)
class DynamicWindowSettings:
    """Sampling and weights; see the module's docstring. ``strict``: reject every rollout with contact within the
    horizon, not only those that cannot stop before it. ``speed_mps``: speed limit."""

    samples: tuple[int, int] = (12, 21)
    horizon_s: float = 2.0
    ahead_m: float = 1.5
    weights: tuple[float, float, float, float] = (1.2, 1.0, 0.02, 0.25)
    margin_m: float = 0.04
    sight_m: float = 0.6
    strict: bool = False
    speed_mps: float = math.inf
    angular_radps: float = math.inf


#: Settings of the DWA baseline of the BARN challenge (Daffan/the-barn-challenge,
#: ``jackal_helper/configs/params/base_local_planner_params.yaml``): slow, practically without limits of acceleration,
#: with distances to path and goal in metres. Its footprint is padded: see ``padding_m`` in ``control_cycle``.
PUBLISHED = DynamicWindowSettings(
    samples=(6, 20),
    horizon_s=2.0,
    ahead_m=2.5,
    weights=(0.75, 1.0, 0.005, 0.0),
    margin_m=0.02,
    sight_m=0.3,
    strict=True,
    speed_mps=0.5,
    angular_radps=1.57,
)


class DynamicWindow:
    """The controller ``dwa``, and with the settings ``PUBLISHED`` the baseline ``dwa_published``."""

    def __init__(self, settings: DynamicWindowSettings | None = None) -> None:
        self.settings = settings or DynamicWindowSettings()

    def reset(self) -> None:
        """No state to reset: each choice is independent."""

    def choose(
        self, motion: MotionState, field: DistanceField, way: LocalPath, body: BodyModel, period_s: float
    ) -> VelocityChoice:
        from app.modules.behaviors.navigation.tracking.rollout_kernels import dynamic_window

        s = self.settings
        low, high, turn, *accelerations = body.limits
        high = min(high, s.speed_mps, max(float(way.points[0, 4]), 0.02))
        limits = (max(low, 0.0) if low >= 0 else 0.0, high, min(turn, s.angular_radps), *accelerations)
        count = max(2, min(len(way.points), int(s.ahead_m / way.spacing)))
        linear, angular, cost, _ = dynamic_window(
            field.distances, field.frame, body.outline, body.radii, limits, motion.state,
            np.ascontiguousarray(way.points[:count]), s.samples, s.weights, period_s, s.horizon_s, s.margin_m,
            s.sight_m, s.strict,
        )  # fmt: skip
        if not math.isfinite(cost):
            return VelocityChoice(0.0, 0.0, True)
        # At rest with path left: every motion costs more than none.
        still = linear < 0.02 and abs(angular) < 0.05 and float(way.points[-1, 3]) > 0.1
        return VelocityChoice(linear, angular, still)
