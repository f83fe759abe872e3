"""The console as one ASGI application."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI, WebSocket
from starlette.types import ASGIApp

from app.base import paths
from app.console.access.auth import Door, Guarded
from app.console.access.credentials import Credentials, Passwords
from app.console.access.origins import Ports
from app.console.description import describe
from app.console.link_shaper import Link, Shaped
from app.console.live.endpoint import live
from app.console.live.face import face
from app.console.live.hub import Hub
from app.console.live.messages import VisitorLink
from app.console.live.protocol import COSTMAP
from app.console.live.tour_visitors import TourVisitors
from app.console.live.visitor_link import visitor_link
from app.console.page import install_page
from app.console.panels import Panel, panels_router
from app.console.problems import install_problem_handlers
from app.console.rehearsals import Rehearsals
from app.console.replays import Replays
from app.console.rest.attention import attention_router
from app.console.rest.camera import camera_router
from app.console.rest.desires import desires_router
from app.console.rest.fleet import fleet_router
from app.console.rest.goal import goal_router
from app.console.rest.lanes import lanes_router
from app.console.rest.link import link_router
from app.console.rest.map_route import route_router
from app.console.rest.maps import maps_router
from app.console.rest.memory import memory_router
from app.console.rest.percepts import percepts_router
from app.console.rest.places import places_router
from app.console.rest.playback import playback_router
from app.console.rest.program import program_router, robot_router
from app.console.rest.recordings import recordings_router
from app.console.rest.rehearsal import rehearsal_router
from app.console.rest.routing import API, add_routes, records
from app.console.rest.session import session_router
from app.console.rest.tour_files import tour_files_router
from app.console.rest.tour_media import LIMITS, tour_media_router
from app.console.rest.tour_run import tour_run_router
from app.console.rest.tours import tours_router
from app.console.rest.viewers import viewers_router
from app.console.rest.visitor import visitor_router
from app.console.rest.webhooks import webhooks_router
from app.console.view.relay import view_router
from app.console.view.scene_port import AtPorts, scene_app
from app.console.view.view import View
from app.console.webhooks.webhooks import Webhooks

if TYPE_CHECKING:
    from app.console.fleet.asking import Fleet
    from app.logs.replay.playback import Playback
    from app.program.system import System


def create_app(
    system: System,
    *,
    playback: Playback | None = None,
    static_dir: Path | None = None,
    token: str | None = None,
    host: str = "127.0.0.1",
    host_names: Sequence[str] = (),
    ports: Ports | None = None,
    early_view: bool = True,
    panels: Mapping[str, Panel] | None = None,
    passwords: Passwords = (),
    replay_options: Sequence[str] = (),
    link: Link | None = None,
    webhooks_file: Path | None = None,
    fleet: Fleet | None = None,
) -> FastAPI:
    """The console of ``system``: REST and live stream under ``/api/v1``, the 3D view under ``/viser``, the page at /.

    ``playback`` plays the recording of a ``system`` that is a replay; None: a running robot.
    ``static_dir`` holds the built page (default: where the build puts it). ``token`` None: any client on this
    computer may use it, under a name of this computer; see :mod:`app.console.access.auth`. ``host_names`` are its names
    beside this computer's own, where a token is needed. ``host`` is where replays that are started from here
    listen. ``ports`` are those it is served at, if the 3D view has one of its own; None: it has none. ``early_view``:
    start the 3D view with the program rather than with its first viewer. ``panels`` are those of packages, by name
    (:func:`app.console.panels.load_panels`). ``passwords`` are those of roles, asked for beside the token;
    ``replay_options`` are options of ``hbba replay`` for replays that are started from here. ``link`` shapes every
    stream, for tests; None: not until it is asked to. Webhooks are kept in ``webhooks_file``; None: not kept.
    ``fleet`` asks the consoles of other robots; it is closed with this one.
    """
    link = link or Link()
    panels = panels or {}
    wanted = sorted({channel for panel in panels.values() for channel in panel.channels})
    hub = Hub(system, playback, wanted, link)
    view = View(system, lambda: hub.is_shown(COSTMAP), early=early_view, playback=playback)
    door = Door(Credentials(token, passwords), host_names, ports=ports)
    replays = Replays(host, token, host_names, options=replay_options)
    rehearsals = Rehearsals()
    visitors = TourVisitors(system, door)
    webhooks = Webhooks(system.timeline, system.clock, webhooks_file) if playback is None else None

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        hub.open()
        view.open()
        leave = visitors.open()
        if webhooks is not None:
            await webhooks.open()
        try:
            yield
        finally:
            leave()
            hub.close()
            if webhooks is not None:
                await webhooks.close()
            if fleet is not None:
                await fleet.close()
            await asyncio.gather(replays.close(), rehearsals.close(), view.close())

    # FastAPI's own documentation pages load scripts from elsewhere; ours need nothing but this server.
    app = _Console(
        door,
        None if ports is None else scene_app(view, ports),
        link,
        lifespan=lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
    )
    app.state.hub = hub
    app.state.view = view
    app.state.replays = replays
    app.state.rehearsals = rehearsals
    install_problem_handlers(app)
    routers = (
        desires_router(system),
        attention_router(system),
        robot_router(system, hub),
        fleet_router(system, hub, fleet),
        percepts_router(system),
        maps_router(system),
        places_router(system),
        route_router(system),
        camera_router(system, hub),
        goal_router(system, hub),
        tour_files_router(system),
        tours_router(system),
        tour_media_router(system),
        tour_run_router(system),
        memory_router(system),
        rehearsal_router(system, rehearsals),
        visitor_router(system, door, visitors, listens=host, names=host_names),
        program_router(system, hub),
        recordings_router(system, replays, None if playback is None else playback.info.path),
        viewers_router(hub, view, ports),
        session_router(door),
        playback_router(playback),
        link_router(link),
        lanes_router(hub, system.clock),
        webhooks_router(webhooks),
    )
    add_routes(app, routers)

    @app.websocket(f"{API}/live")
    async def live_stream(websocket: WebSocket) -> None:
        await live(websocket, hub, system.clock)

    @app.websocket(f"{API}/face")
    async def face_stream(websocket: WebSocket) -> None:
        await face(websocket, system, link_of_visitors)

    @app.websocket(f"{API}/visitor/live")
    async def visitor_stream(websocket: WebSocket) -> None:
        await visitors.serve(websocket)

    def link_of_visitors(base: str) -> VisitorLink:
        return visitor_link(door.visitors.key, base=base, listens=host, names=host_names, asks=door.asks)

    app.include_router(view_router(view))
    app.include_router(panels_router(panels))
    describe(app, API, answers=records(routers), token_needed=door.asks)

    install_page(app, static_dir or paths.static_dir())
    return app


class _Console(FastAPI):
    """FastAPI behind the door, outside even of the layer that answers 500; outermost the link, which may be shaped."""

    def __init__(self, door: Door, scene: ASGIApp | None, link: Link, **options: Any) -> None:
        super().__init__(**options)
        self._door = door
        self._scene = scene
        self._link = link

    def build_middleware_stack(self) -> ASGIApp:
        stack = super().build_middleware_stack()
        if self._scene is not None and self._door.ports is not None:
            stack = AtPorts(stack, self._scene, self._door.ports)
        return Shaped(Guarded(stack, self._door, LIMITS), self._link)
