"""The robot and the program that runs it: state, emergency stop, modules, channels, health."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response

from app.attention.timeline_writer import source_words
from app.console import reports
from app.console.access.identity import LOCAL, identity_of
from app.console.drive.drive_controller import NOT_YOURS, PRESSED_AGAIN, RECORDING
from app.console.live.hub import Hub
from app.console.playback import rate
from app.console.problems import Problem
from app.console.recordings import RecorderWatch
from app.console.records.program import ChannelList, ChannelReport, Health, ModuleList
from app.console.records.robot import EStop, RobotReport
from app.console.rest.answers import Json, problems
from app.console.rest.desires import OPERATOR_PARAMETER, source_of
from app.console.rest.routing import router as api_router
from app.messages import ModuleReport
from app.program.module_meter import ModuleMeter, subscription_counters

if TYPE_CHECKING:
    from app.messages import LinkStatus
    from app.program.system import System
    from app.runtime.freshness import Freshness
    from app.runtime.graph import Graph


#: The person who releases the emergency stop has looked at the robot within this time (s).
SEEN_WITHIN_S = 5.0
#: The guard reports 20 times a second; a stop it has not confirmed by then is not to be relied on.
CONFIRM_WITHIN_S = 0.5
LOOK_FIRST = (
    f"The emergency stop is latched: look at the robot, then release it with ?seen= and the stamp of GET /robot, "
    f"at most {SEEN_WITHIN_S:.0f} s old."
)


def robot_router(system: System, hub: Hub) -> APIRouter:
    """Routes of ``/robot``."""
    router = api_router("robot")

    @router.get("/robot", response_model=RobotReport, summary="State of the robot: pose, guard, driver")
    async def get_robot() -> Response:
        now, speed = system.clock.now(), rate(system.clock)
        status = hub.link_status
        return Json(
            RobotReport(
                stamp=now,
                robot=reports.robot_facts(system, replayed=hub.driving.recording),
                guard=reports.guard(status, now, speed, system.body_restarter.problem),
                world_rate=1.0 if status is None else status.world_rate,
                odometry=reports.odometry_report(reports.latest(system.graph, "odometry")),
                driver=hub.driving.lease.driver_name,
                exploited=reports.exploited(reports.latest(system.graph, "exploitation"), now, speed),
                landmarks=reports.landmarks(reports.latest(system.graph, "landmarks")),
                battery=reports.latest(system.graph, "battery"),
            )
        )

    @router.post(
        "/stop",
        response_model=EStop,
        summary="Latch the emergency stop",
        openapi_extra=OPERATOR_PARAMETER,
        responses=problems(409, 504),
    )
    async def latch_e_stop(request: Request) -> Response:
        """Latches the emergency stop in the guard: the wheels are commanded to zero until it is released here or on the
        page. Answers once the guard has confirmed it. Needs no body. May be repeated."""
        _refuse_recording(hub)
        confirmed = asyncio.get_running_loop().create_future()

        def heard(status: LinkStatus) -> None:
            if status.e_stopped and not confirmed.done():
                confirmed.set_result(None)

        detach = system.link.attach("status", heard)
        try:
            hub.driving.e_stop(source_words(source_of(request)), by=identity_of(request.scope) or LOCAL)
            async with asyncio.timeout(CONFIRM_WITHIN_S):
                await confirmed
        except TimeoutError:
            raise Problem(
                504,
                "unconfirmed",
                f"The stop was sent, but the robot's body did not confirm it within {CONFIRM_WITHIN_S} s: "
                "use the hardware stop if it moves.",
            ) from None
        finally:
            detach()
        return Json(EStop("latched", system.clock.now()))

    @router.delete("/stop", response_model=EStop, summary="Release the emergency stop", responses=problems(409))
    async def release_e_stop(
        request: Request,
        seen: Annotated[
            float | None,
            Query(
                allow_inf_nan=False,
                description="The `stamp` of GET /robot or of the stop's own answer, at most 5 s old; may be left out "
                "only where nothing is latched.",
            ),
        ] = None,
    ) -> Response:
        """A stop that was pressed after `seen` stays latched, so that a late release does not undo a stop that its
        sender has not seen. The base stays still until the next fresh command. Answers once the guard
        has confirmed it, or half a second later: a goal that is given next is not refused for a latch that is gone.
        An operator releases what no other pressed, a supervisor any stop."""
        _refuse_recording(hub)
        if not hub.driving.lease.e_stopped:
            return Json(EStop("released", system.clock.now()))
        if seen is None or not 0 <= system.clock.now() - seen <= SEEN_WITHIN_S:
            raise Problem(409, "stop-not-seen", LOOK_FIRST)
        if not hub.driving.may_release(identity_of(request.scope) or LOCAL):
            raise Problem(403, "stop-of-another", NOT_YOURS)
        released = asyncio.Event()
        detach = system.link.attach("status", lambda status: None if status.e_stopped else released.set())
        try:
            if not hub.driving.clear_e_stop(seen):
                raise Problem(409, "stop-not-seen", PRESSED_AGAIN)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(released.wait(), CONFIRM_WITHIN_S)
        finally:
            detach()
        return Json(EStop("released", system.clock.now()))

    return router


def _refuse_recording(hub: Hub) -> None:
    if hub.driving.recording:
        raise Problem(409, "a-recording", RECORDING)


def program_router(system: System, hub: Hub) -> APIRouter:
    """Routes of ``/modules``, ``/channels`` and ``/health``."""
    router = api_router("program")
    recorder = RecorderWatch(system)

    def meter() -> ModuleMeter:
        """That measures from the start."""
        return ModuleMeter(system.graph.modules, system.supervisor, system.load)

    @router.get("/modules", response_model=ModuleList, summary="Modules, their load and counters")
    async def list_modules() -> Response:
        load = system.load.latest
        return Json(ModuleList(load.stamp, round(load.process, 2), meter().sample()))

    @router.get("/modules/{name}", response_model=ModuleReport, summary="One module", responses=problems(404))
    async def get_module(name: Annotated[str, Path(min_length=1, examples=["QRCodeDetector"])]) -> Response:
        slot = system.graph.modules.get(name)
        if slot is None:
            known = ", ".join(system.graph.modules)
            raise Problem(404, "no-such-module", f"No module is called {name}; there are: {known}.")
        return Json(meter().module(slot))

    @router.get("/channels", response_model=ChannelList, summary="Channels, their freshness and counters")
    async def list_channels() -> Response:
        fresh = system.freshness.read(system.clock.now())
        return Json(ChannelList(tuple(_channel(system.graph, name, fresh[name]) for name in system.graph.channels)))

    @router.get("/health", response_model=Health, summary="Health of the program")
    async def get_health() -> Response:
        """Open to all; `degraded` while a module does not run, the body is silent, or a recording has ended by itself,
        until that is stopped (`POST /recordings/stop`) or another begins."""
        problems = [
            f"{state.name}: {state.status}" for state in system.supervisor.states.values() if state.status != "running"
        ]
        guard = reports.guard(hub.link_status, system.clock.now(), rate(system.clock), system.body_restarter.problem)
        if guard.state in ("silent", "sensor_failure"):
            problems.append(guard.reason)
        if stopped := recorder.problem():
            problems.append(stopped)
        return Json(Health("degraded" if problems else "ok", system.clock.now(), tuple(problems)))

    return router


def _channel(graph: Graph, name: str, freshness: Freshness) -> ChannelReport:
    """A channel of the table, how fresh it is, and its counters."""
    spec, channel = graph.specs[name], graph.channels[name]
    statistics, fresh = channel.statistics(), reports.source_state(name, freshness)
    return ChannelReport(
        name=name,
        title=spec.title,
        type=spec.message,
        frame=spec.frame,
        rate_hz=spec.rate_hz,
        expected_hz=fresh.expected_hz,
        measured_hz=fresh.rate_hz,
        decimable=spec.decimable,
        wanted=channel.wanted,
        producer=graph.producers.get(name),
        published=statistics.published,
        state=fresh.state,
        age_ms=fresh.age_ms,
        stale_after_ms=None if freshness.limit_s is None else round(1e3 * freshness.limit_s, 1),
        subscriptions={
            consumer: subscription_counters(counters) for consumer, counters in statistics.subscriptions.items()
        },
    )
