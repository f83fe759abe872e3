"""Ways that are not driven now: by the same planner and costs, with the time they would take."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.maps.route_service import LegState, RouteLeg
from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.controller import BodyModel
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostSettings
from app.modules.behaviors.navigation.planning.global_planner import GlobalPlanner, PlanRequest, PlanResult

#: So many legs are kept: a tour that is edited asks again for those that did not change.
_KEPT = 512
#: A turn by less (rad) than this is made while driving.
_TURN_RAD = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class LegRequest:
    """Input of one leg: as of :class:`PlanRequest`; ``speed``: share of the greatest speed, in ]0, 1]."""

    grid: OccupancyGrid
    zones: tuple[Zone, ...]
    start: Pose2
    goal: Pose2
    speed: float
    persistent_obstacles: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))


class RouteFinder:
    """Finds legs for one body, with a planner of its own; for use in one thread at a time."""

    def __init__(self, footprint: Footprint, body: BodyModel, costs: CostSettings | None = None) -> None:
        self._planner = GlobalPlanner(footprint, costs)
        self._body = body
        self._found: dict[tuple[float, ...], RouteLeg] = {}
        self._found_on: tuple[OccupancyGrid, tuple[Zone, ...], NDArray[np.float64]] | None = None

    def find(self, request: LegRequest) -> RouteLeg:
        """The leg, or one without a path that says why."""
        start, goal = request.start, request.goal
        self._forget_unless(request)
        heading = goal.theta if math.isfinite(goal.theta) else math.inf
        key = (start.x, start.y, start.theta, goal.x, goal.y, heading, request.speed)
        found = self._found.get(key)
        if found is None:
            result = self._planner.find(
                PlanRequest(
                    request.grid,
                    request.zones,
                    X_MO=Pose2(),
                    X_MB=start,
                    goal=goal,
                    persistent_obstacles=request.persistent_obstacles,
                )
            )
            found = leg_of(result, start, self._body.limited(request.speed))
            if len(self._found) >= _KEPT:
                self._found.clear()
            self._found[key] = found
        return found

    def _forget_unless(self, request: LegRequest) -> None:
        """Legs hold while map, zones and obstacles are the same objects."""
        on = (request.grid, request.zones, request.persistent_obstacles)
        if self._found_on is None or any(a is not b for a, b in zip(self._found_on, on, strict=True)):
            self._found.clear()
            self._found_on = on


def leg_of(result: PlanResult, start: Pose2, body: BodyModel) -> RouteLeg:
    """The leg that ``result`` is, for a ``body`` that stands at ``start`` before it and at its end after it."""
    plan = result.plan
    if not len(plan.poses):
        return RouteLeg("none", plan.reason, np.empty((0, 2)), 0.0, 0.0)
    state: LegState = "near" if plan.code == "near" else "way"
    points = plan.poses[:, :2]
    steps = np.hypot(*np.diff(points, axis=0).T)
    _, fastest, turning, accelerating, *_ = body.limits
    shares = result.speed_share(0.5 * (points[1:] + points[:-1])) if len(steps) else np.empty(0)
    driving = float((steps / (fastest * shares)).sum())
    final = float(plan.poses[-1, 2])
    speeding_up = min(fastest / accelerating, driving) if accelerating > 0 else 0.0
    turns = 0.0
    if len(points) > 2:
        first = math.atan2(*(points[1] - points[0])[::-1])
        last = math.atan2(*(points[-1] - points[-2])[::-1])
        turns = _turn(first - start.theta) + _turn(final - last)
    else:
        turns = _turn(final - start.theta)
    duration = driving + speeding_up + turns / turning
    return RouteLeg(state, plan.reason, points, plan.length_m, duration)


def _turn(by: float) -> float:
    """The size (rad) of a turn in place; 0 for a heading that does not matter."""
    size = abs(wrap_angle(by)) if math.isfinite(by) else 0.0
    return size if size >= _TURN_RAD else 0.0
