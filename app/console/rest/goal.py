"""The goal that people give the robot: one desire of class GoTo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from app.attention.desires import Desire
from app.base.geometry import wrap_angle
from app.console import reports
from app.console.drive.goals import GO_TO, REPORT, asked_here, dismiss_given_up, pause_tour, withdraw
from app.console.drive.place_goals import goal_at
from app.console.live.hub import Hub
from app.console.problems import Problem
from app.console.records.navigation import NavigationModel
from app.console.rest.answers import Json, problems
from app.console.rest.desires import OPERATOR_PARAMETER, refuse_too_many, source_of
from app.console.rest.map_models import GoalRequest
from app.console.rest.routing import router as api_router
from app.messages.base import doc

if TYPE_CHECKING:
    from app.program.system import System

#: The greatest there is: a goal given by a person is for now. Of equal desires the newest counts.
INTENSITY = 8.0
#: The utility of the strategy that plans a path with all sensors, though it is slow. Asked for less, attention would
#: choose the straight line under way, for any sound that is worth a look.
UTILITY = 4.0
LATCHED = "The emergency stop is latched: release it first."
RECORDING = "This is a recording: there is no robot to send anywhere."


@dataclass(frozen=True, slots=True)
class Goal:
    """The goal desired, and the state of navigation."""

    desire: Annotated[Desire | None, doc("The strongest desire of class GoTo; null: there is none.")]
    navigation: Annotated[NavigationModel | None, doc("null: this program goes nowhere by itself.")]


def goal_router(system: System, hub: Hub) -> APIRouter:
    """Routes of ``/goal``."""
    router = api_router("maps")
    workspace = system.workspace

    @router.get("/goal", response_model=Goal, summary="The goal and the state of navigation")
    async def get_goal() -> Response:
        """What is desired, and what the behavior that goes there is about."""
        desire = workspace.wanted(GO_TO)
        navigation = reports.latest(system.graph, REPORT)
        return Json(Goal(desire, navigation))

    @router.put(
        "/goal",
        response_model=Desire,
        summary="Send the robot somewhere",
        openapi_extra=OPERATOR_PARAMETER,
        responses=problems(400, 409, 422),
    )
    async def set_goal(goal: GoalRequest, request: Request) -> Response:
        """Creates a desire of class GoTo, or changes the one that was created so before: there is one goal of people at
        a time, and a second takes the first one's place. Attention weighs it as any other; how the robot does is in
        `navigation` of GET /goal and of the live stream. The same goal again changes nothing. A goal by `place` is the
        pose that the place has now; one in an obstacle of the map or in a keep-out zone is refused."""
        if hub.driving.recording:
            raise Problem(409, "a-recording", RECORDING)
        if hub.driving.lease.e_stopped:
            raise Problem(409, "e-stop-latched", LATCHED)
        if GO_TO not in system.classes or not any(strategy.cls == GO_TO for strategy in system.table.strategies):
            raise Problem(
                409, "cannot-go", "This program goes nowhere by itself: it has no strategy for the class GoTo."
            )
        params = _where_to(system, goal)
        if goal.speed is not None:
            params["speed"] = goal.speed
        source = source_of(request)
        if not asked_here(workspace):
            refuse_too_many(system)
        with workspace.transaction():
            standing = asked_here(workspace)
            heard = workspace.strongest().get(GO_TO)
            # Only the newest of equally intense desires counts: an older one is replaced.
            kept = next((d for d in standing if heard is not None and d.id == heard.id and d.source == source), None)
            for desire in standing:
                if desire is not kept:
                    workspace.remove(desire.id)
            if kept is not None and kept.params == system.classes[GO_TO].validated(params):
                # Its progress so far, its path among it, is kept.
                desire = kept
            elif kept is None:
                desire = workspace.add(GO_TO, intensity=INTENSITY, utility=UTILITY, params=params, source=source)
            else:
                desire = workspace.change(
                    kept.id, intensity=INTENSITY, utility=UTILITY, security=False, params=params, ttl=None
                )
        return Json(desire)

    @router.delete("/goal", status_code=204, summary="Cancel the goal")
    async def cancel_goal() -> Response:
        """Withdraws every desire of class GoTo that came over the console, and every one to dock or to explore, also
        the robot's own; a goal that the robot gave up is no longer reported. A guided tour on its way is paused. May be
        repeated."""
        withdraw(workspace)
        pause_tour(system)
        dismiss_given_up(system)
        return Response(status_code=204)

    return router


def _where_to(system: System, goal: GoalRequest) -> dict[str, Any]:
    """Parameters of the desire. Raises Problem where ``goal`` is not one of both kinds, or its place is of no use."""
    if goal.place is not None:
        given = [name for name in ("x", "y", "heading") if getattr(goal, name) is not None]
        if given:
            words = "is given by the place; leave it out, or leave out place"
            errors = [(name, words) for name in given]
            raise Problem(422, "invalid-request", "; ".join(map(": ".join, errors)), errors=errors)
        return goal_at(system, goal.place, "place")
    missing = [name for name in ("x", "y") if getattr(goal, name) is None]
    if missing:
        errors = [(name, "is missing; a goal has x and y, or place") for name in missing]
        raise Problem(422, "invalid-request", "; ".join(map(": ".join, errors)), errors=errors)
    params = {"x": goal.x, "y": goal.y}
    if goal.heading is not None:
        params["heading"] = wrap_angle(goal.heading)
    return params
