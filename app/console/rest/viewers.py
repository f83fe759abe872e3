"""Connected pages and 3D views, and the quality of their connections."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from app.console.live.hub import Hub
from app.console.records.program import PageReport, ViewerList, ViewReport
from app.console.rest.answers import Json
from app.console.rest.routing import router as api_router
from app.console.view.view import View


def viewers_router(hub: Hub, view: View) -> APIRouter:
    """Routes of ``/viewers``."""
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
                    waits=hub.waits(viewer),
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

    return router
