"""Connected pages and 3D views, and the quality of their connections."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import ConfigDict, Field

from app.console.access.origins import Ports
from app.console.live.hub import Hub
from app.console.problems import Problem
from app.console.records.program import PageReport, SceneAddress, ScenePoint, ViewerList, ViewReport
from app.console.rest.answers import Json, problems
from app.console.rest.models import Request as RequestBody
from app.console.rest.routing import router as api_router
from app.console.view.view import View


class SceneClick(RequestBody):
    """A point of a 3D view."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"viewer": "5f3a0c9e7d21", "u": 0.5, "v": 0.4}]})

    viewer: str = Field(
        min_length=1, max_length=32, description="The view's name for itself, as `GET /viewers` lists it."
    )
    u: float = Field(ge=0, le=1, description="From its left edge, as a share of its width.")
    v: float = Field(ge=0, le=1, description="From its top edge, as a share of its height.")


def viewers_router(hub: Hub, view: View, ports: Ports | None) -> APIRouter:
    """Routes of ``/viewers`` and ``/scene``."""
    router = api_router("session")

    @router.get("/viewers", response_model=ViewerList, summary="Connected pages and 3D views, and their connections")
    async def list_viewers() -> Response:
        driver = hub.driving.lease.driver
        pages = []
        for viewer in hub.viewers:
            counters = viewer.outbox.statistics()
            # A recording's clock does not show when a page said something.
            age_s = None if hub.driving.recording else viewer.age.last.age_s
            pages.append(
                PageReport(
                    operator=viewer.operator,
                    driving=viewer.session == driver,
                    rtt_ms=viewer.rtt_ms,
                    late_ms=None if age_s is None else round(1e3 * age_s, 1),
                    waits=hub.status.waits(viewer),
                    waiting=counters.waiting,
                    sent=counters.taken,
                    replaced=counters.replaced,
                )
            )
        views = tuple(
            ViewReport(
                viewer=session.viewer,
                lag_ms=None if session.budget.lag_s is None else round(1e3 * session.budget.lag_s, 1),
                points=int(session.budget.points),
                period_ms=round(1e3 * session.budget.period_s, 1),
                sent_bytes=session.sent_bytes,
            )
            for session in view.sessions
        )
        return Json(ViewerList(tuple(pages), views))

    @router.get("/scene", response_model=SceneAddress, summary="Where the 3D view for a page's frame is")
    async def get_scene(request: Request) -> Response:
        """Its address on the port of the 3D view, for a client that reached the console under this request's `Host`.
        Where that names another port than the console's own, as behind a proxy, the second port's address is not known,
        and the view is at `/viser/` here."""
        origin = None if ports is None else ports.scene_origin(request.scope)
        return Json(SceneAddress(None if origin is None else f"{origin}/viser/"))

    @router.post(
        "/scene/point",
        response_model=ScenePoint,
        summary="What a point of a 3D view shows",
        responses=problems(400, 409, 422),
    )
    async def find_scene_point(click: SceneClick) -> Response:
        """The first thing on the ray of that view's camera, as it is drawn there: a poster, the map's walls, what the
        depth camera saw, or the floor; and where that is."""
        pick = await view.pick(click.viewer, click.u, click.v)
        if pick is None:
            raise Problem(409, "no-such-view", "That 3D view is not open any more: reload the page.")
        x, y, z = (None, None, None) if pick.p is None else (round(value, 3) for value in pick.p)
        text, landmark = (None, None) if pick.poster is None else (pick.poster.text, pick.poster.id)
        return Json(ScenePoint(pick.kind, pick.frame, x=x, y=y, z=z, text=text, landmark=landmark))

    return router
