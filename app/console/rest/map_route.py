"""Routes on the map in use: what driving from place to place would be like, without driving."""

from __future__ import annotations

import asyncio
import math
from itertools import pairwise
from typing import TYPE_CHECKING

import cv2
import numpy as np
from fastapi import APIRouter
from fastapi.responses import Response
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.console.drive.place_goals import place_called
from app.console.problems import Problem
from app.console.records.route import RouteLegReport, RouteReport
from app.console.rest.answers import Json, problems
from app.console.rest.route_models import RoutePoint, RouteRequest
from app.console.rest.routing import router as api_router
from app.maps.map_service import MapUnavailable
from app.maps.places import pose_of
from app.maps.route_service import RouteLeg

if TYPE_CHECKING:
    from app.program.system import System

#: So many points of a path are sent; corners within so many metres of it are left out.
MOST_CORNERS, STRAIGHT_M = 200, 0.03
#: So many requests wait for their turn; more are refused.
MOST_WAITING = 4


def route_router(system: System) -> APIRouter:
    """The route ``/map/route``."""
    router = api_router("maps")
    #: One route after another: planning takes a core.
    one = asyncio.Lock()
    waiting = 0

    @router.post("/map/route", response_model=RouteReport, summary="Plan a route", responses=problems(400, 409, 422))
    async def plan_route(wanted: RouteRequest) -> Response:
        """Leg by leg, by the robot's own planner, on the map in use, its zones and what it keeps in mind of obstacles;
        what is there for the moment does not count. Nothing moves. A leg that cannot be driven says why."""
        nonlocal waiting
        if waiting >= MOST_WAITING:
            raise Problem(409, "busy", f"{MOST_WAITING} routes wait to be planned already: try again.")
        poses = [_pose(system, number, point) for number, point in enumerate(wanted.points)]
        waiting += 1
        try:
            async with one:
                legs = await _legs(system, poses, wanted.speed)
        finally:
            waiting -= 1
        name = system.map.server.name if system.map.available else ""
        driven = [leg for leg in legs if leg.state != "none"]
        length = round(sum(leg.length_m for leg in driven), 2)
        return Json(RouteReport(name, legs, length, round(sum(leg.duration_s for leg in driven), 1)))

    return router


async def _legs(system: System, poses: list[Pose2], speed: float) -> tuple[RouteLegReport, ...]:
    legs = []
    try:
        for start, goal in pairwise(poses):
            heading = start.theta if math.isfinite(start.theta) else math.atan2(goal.y - start.y, goal.x - start.x)
            leg = await system.routes.planner.leg(Pose2(start.x, start.y, heading), goal, speed)
            legs.append(leg_report(leg))
    except MapUnavailable as refusal:
        raise Problem(409, "map-unavailable", f"{refusal}.") from None
    return tuple(legs)


def leg_report(leg: RouteLeg) -> RouteLegReport:
    """``leg`` as it is sent."""
    return RouteLegReport(
        leg.state,
        leg.reason,
        length_m=round(leg.length_m, 2),
        duration_s=round(leg.duration_s, 1),
        path=corners(leg.path),
    )


def corners(path: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    """The corners of ``path`` (N, 2), at most ``MOST_CORNERS``, from its first point to its last; cm are enough to draw
    it."""
    if len(path) > 2:
        tolerance_m = STRAIGHT_M
        thinned = path
        # Relative to its middle, so that 32 bits are enough far from the map's origin.
        middle = path.mean(axis=0)
        while len(thinned) > MOST_CORNERS or thinned is path:
            line = (path - middle).astype(np.float32)[:, None]
            thinned = cv2.approxPolyDP(line, tolerance_m, closed=False)[:, 0].astype(np.float64) + middle
            tolerance_m *= 2
        path = thinned
    return tuple((round(x, 2), round(y, 2)) for x, y in path.tolist())


def _pose(system: System, number: int, point: RoutePoint) -> Pose2:
    """Where ``point`` is on the map. Raises Problem."""
    field = f"points.{number}"
    if (point.place is None) == (point.x is None) or (point.x is None) != (point.y is None):
        words = "either place is needed, or x and y"
        raise Problem(422, "invalid-request", f"{field}: {words}.", errors=[(field, words)])
    if point.place is None:
        assert point.x is not None
        assert point.y is not None
        return Pose2(point.x, point.y, math.nan if point.heading is None else point.heading)
    pose = pose_of(place_called(system, point.place, f"{field}.place"))
    return pose if point.heading is None else Pose2(pose.x, pose.y, point.heading)
