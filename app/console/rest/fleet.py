"""The robots of a fleet: this one, and those whose consoles it knows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import Response

from app.console import reports
from app.console.fleet.robots import state_of, with_unique_names
from app.console.live.hub import Hub
from app.console.playback import rate
from app.console.records.fleet import FleetReport, FleetRobot
from app.console.rest.answers import Json
from app.console.rest.routing import router as api_router
from app.messages import BatteryState

if TYPE_CHECKING:
    from app.console.fleet.asking import Fleet
    from app.program.system import System


def fleet_router(system: System, hub: Hub, fleet: Fleet | None) -> APIRouter:
    """Routes of ``/fleet``; ``fleet`` None: this robot knows no others."""
    router = api_router("robot")

    @router.get("/fleet", response_model=FleetReport, summary="The robots of the fleet: state, and who drives")
    async def get_fleet() -> Response:
        """This robot, and those of the file of `hbba run --fleet`, whose consoles are asked now: one that does not
        answer within 2 s is `unreachable`."""
        others = () if fleet is None else await fleet.robots()
        return Json(FleetReport(system.clock.now(), with_unique_names((_this_robot(system, hub), *others))))

    return router


def _this_robot(system: System, hub: Hub) -> FleetRobot:
    now, speed = system.clock.now(), rate(system.clock)
    facts = reports.robot_facts(system, replayed=hub.driving.recording)
    guard = reports.guard(hub.link_status, now, speed, system.body_restarter.problem)
    state, detail = state_of(guard.state, guard.reason, e_stopped=guard.e_stopped)
    battery = reports.latest(system.graph, "battery")
    return FleetRobot(
        name=facts.called,
        body=facts.name,
        url="",
        state=state,
        detail=detail,
        driver=hub.driving.lease.driver_name,
        exploited=reports.exploited(reports.latest(system.graph, "exploitation"), now, speed),
        charge=battery.charge if isinstance(battery, BatteryState) else None,
        simulated=facts.simulated,
    )
