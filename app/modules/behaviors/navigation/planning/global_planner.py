"""Global planner: keeps the cost field up to date, plans, and keeps a plan until another is clearly better.

Runs in a thread of its own beside the control cycle: planning may take longer than a cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostField, CostSettings, cost_field, with_obstacles
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow
from app.modules.behaviors.navigation.costmap.transient_obstacle_layer import TransientObstacles, off_map, remember
from app.modules.behaviors.navigation.costmap.zone_layer import rasterize
from app.modules.behaviors.navigation.planning.goal_planning import (
    SUBSTITUTES,
    GlobalPlan,
    PlanSettings,
    body_fits,
    check_path,
    plan,
    why_replan,
)
from app.modules.behaviors.navigation.planning.reference_path import SpeedAt

#: Least advantage of another plan over the one in force (cost, in metres of open floor).
_WORTH_M = 0.3
#: A substitute place that is so much (m) nearer to the goal is worth another plan.
_NEARER_M = 0.1
#: A substitute place within this share of the tolerance will do: the body stops beside it.
_WITHIN = 0.8
#: Cost per metre through lethal cells.
_LETHAL = 50.0


@dataclass(frozen=True, slots=True, eq=False)
class PlanRequest:
    """Input of one planning. ``goal``: pose on the map, heading NaN for any; ``tolerance_m``: so near to it will do
    (infinite: no goal is ``taken``); ``around``: the local costmap, None to plan on the map alone; ``opened_up``:
    unknown cells cost nothing and transient obstacles are ignored; ``kept``: the plan in force to this goal; ``why``:
    the reason to replace it in any case ("": only by a cheaper one); ``footprint``: of the body with its arms as they
    are now, None for the usual one; ``persistent_obstacles`` (N, 2): remembered obstacles that the map does not have, m
    on the map."""

    grid: OccupancyGrid
    zones: tuple[Zone, ...]
    X_MO: Pose2
    X_MB: Pose2
    goal: Pose2
    around: CostmapWindow | None = None
    opened_up: bool = False
    kept: GlobalPlan | None = None
    why: str = ""
    footprint: Footprint | None = None
    persistent_obstacles: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    tolerance_m: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class PlanResult:
    """The ``plan`` to follow; ``changed``: whether it differs from the plan kept so far; ``speed_share``: looks up, at
    points (N, 2) of the map, the share of the greatest speed that zones allow, in ]0, 1]."""

    plan: GlobalPlan
    changed: bool
    why: str
    speed_share: SpeedAt


class GlobalPlanner:
    """Plans for one body. A plan in force is replaced by one whose cost is lower by the share ``better``."""

    def __init__(
        self,
        footprint: Footprint,
        costs: CostSettings | None = None,
        plans: PlanSettings | None = None,
        *,
        better: float = 0.12,
    ) -> None:
        self._footprint = footprint
        self._costs = costs or CostSettings()
        self._plans = plans
        self._better = better
        self._usual = _Field()
        #: Of the body with its arms stretched out.
        self._stretched = _Field()
        self._temporary = TransientObstacles.none()

    def find(self, request: PlanRequest) -> PlanResult:
        """A path for ``request``, or a plan without path that gives the reason."""
        stretched = request.footprint is not None and request.footprint.with_arms
        footprint = self._footprint if request.footprint is None or not stretched else request.footprint
        cached = self._stretched if stretched else self._usual
        costs = replace(self._costs, unknown="free") if request.opened_up else self._costs
        field = cached.of(request, footprint, costs)
        if request.opened_up or request.around is None:
            self._temporary = TransientObstacles.none()
        if request.around is not None:
            self._temporary = remember(self._temporary, request.around, request.X_MO, field)
        live = self._live(request, field)
        why = request.why
        kept = request.kept
        rest_cost = math.inf
        if kept is not None and len(kept.poses):
            check = check_path(live, kept.poses, request.X_MB)
            why = why or why_replan(check)
            rest_cost = _cost_along(live, kept.poses[check.nearest :])
        found = plan(live, request.X_MB, request.goal, self._plans)
        if found.code == "near" and found.away_m(request.goal) > _WITHIN * request.tolerance_m:
            found = self._beside(live, self._lasting(request, field), request, found)
        if stretched and len(found.poses) == 0:
            at_rest = self._live(request, self._usual.of(request, self._footprint, costs))
            found = _because_of_arms(found, plan(at_rest, request.X_MB, request.goal, self._plans))
        if not why and kept is not None:
            why = _why_nearer(kept, found, request.goal)
        worse = _cost_along(live, found.poses) > min((1.0 - self._better) * rest_cost, rest_cost - _WORTH_M)
        if kept is not None and len(kept.poses) and not why and (len(found.poses) == 0 or worse):
            return PlanResult(kept, False, "", cached.speed_share)
        if kept is not None and found.code == kept.code and len(found.poses) == len(kept.poses) == 0:
            return PlanResult(found, found.reason != kept.reason, why, cached.speed_share)
        return PlanResult(found, True, why or "a better way was found", cached.speed_share)

    def _live(self, request: PlanRequest, field: CostField) -> CostField:
        """``field`` with the obstacles that the map does not have."""
        points = np.concatenate((self._temporary.points, _kept_points(request, field)))
        return with_obstacles(field, points) if len(points) else field

    def _beside(self, live: CostField, lasting: CostField, request: PlanRequest, nearest: GlobalPlan) -> GlobalPlan:
        """The plan to a place beside a goal that is taken, to turn and to watch it at; ``nearest`` where there is none,
        and of a goal that is not free in ``lasting`` either."""
        if not body_fits(lasting, request.goal):
            return nearest
        settings = replace(self._plans or PlanSettings(), room_to_turn=True)
        found = plan(live, request.X_MB, request.goal, settings)
        return replace(found if found.code == "near" else nearest, code="taken")

    def _lasting(self, request: PlanRequest, field: CostField) -> CostField:
        """``field`` with the obstacles that are kept with the map alone."""
        points = _kept_points(request, field)
        return with_obstacles(field, points) if len(points) else field


class _Field:
    """The cost field of one footprint, computed again as far as the map, zones or costs changed."""

    def __init__(self) -> None:
        self._field: CostField | None = None
        self._grid: OccupancyGrid | None = None
        self._made_with: tuple[tuple[Zone, ...], CostSettings, Footprint] | None = None
        self._shares: NDArray[np.float32] | None = None

    def of(self, request: PlanRequest, footprint: Footprint, costs: CostSettings) -> CostField:
        made_with = (request.zones, costs, footprint)
        if self._field is None or request.grid is not self._grid or made_with != self._made_with:
            previous = self._field if made_with == self._made_with else None
            self._field = cost_field(request.grid, footprint, request.zones, costs, previous)
            self._grid, self._made_with = request.grid, made_with
            _, self._shares = rasterize(request.zones, self._field.frame)
        return self._field

    @property
    def speed_share(self) -> SpeedAt:
        field, shares = self._field, self._shares
        assert field is not None
        assert shares is not None

        def at(points: NDArray[np.float64]) -> NDArray[np.float64]:
            cells, inside = field.frame.cells(points)
            found = np.ones(len(points))
            found[inside] = shares[cells[inside, 0], cells[inside, 1]]
            return found

        return at


def _kept_points(request: PlanRequest, field: CostField) -> NDArray[np.float64]:
    if request.opened_up or not len(request.persistent_obstacles):
        return np.empty((0, 2))
    return off_map(request.persistent_obstacles, field)


def _why_nearer(kept: GlobalPlan, found: GlobalPlan, goal: Pose2) -> str:
    """The reason to replace a plan to a substitute place by one that ends nearer to the goal; "" where none does."""
    if kept.code not in SUBSTITUTES:
        return ""
    if found.code == "way":
        return "the goal itself can be reached now"
    nearer = found.away_m(goal) < kept.away_m(goal) - _NEARER_M
    return "a place nearer to the goal can be reached now" if nearer else ""


def _because_of_arms(found: GlobalPlan, at_rest: GlobalPlan) -> GlobalPlan:
    """``found``, a plan without a path, with the arms as the reason where there is one with the arms ``at_rest``."""
    if len(at_rest.poses) == 0:
        return at_rest
    return replace(found, code="arms", reason="the arms are stretched out too far; with them at rest there is a way")


def _cost_along(field: CostField, poses: NDArray[np.float64]) -> float:
    """Cost of the path (N, 3), in metres of open floor; lethal cells, as on the way out of a tight place, cost
    ``_LETHAL``."""
    if len(poses) < 2:
        return 0.0
    cells, inside = field.frame.cells(poses[:, :2])
    costs = np.full(len(poses), 1.0)
    costs[inside] = field.cost[cells[inside, 0], cells[inside, 1]]
    costs[~np.isfinite(costs)] = _LETHAL
    steps = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    return float((0.5 * (costs[1:] + costs[:-1]) * steps).sum())
