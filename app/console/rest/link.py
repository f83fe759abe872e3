"""The link between the program and its pages, shaped for tests: see docs/operators-guide.md."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from app.base.network_link import LinkSettings
from app.console.link_shaper import Link
from app.console.problems import Problem
from app.console.records.link import LinkReport
from app.console.rest.answers import Json, problems
from app.console.rest.link_models import LinkChange
from app.console.rest.routing import router as api_router


def link_router(link: Link) -> APIRouter:
    """Routes of ``/link``."""
    router = api_router("session")

    @router.get("/link", response_model=LinkReport, summary="How the link to the pages is shaped, for tests")
    async def get_link() -> Response:
        return Json(link.report())

    @router.put(
        "/link",
        response_model=LinkReport,
        summary="Shape the link to the pages, for tests",
        responses=problems(400, 422),
    )
    async def put_link(change: LinkChange) -> Response:
        """Delays and bounds every stream between the program and its pages from now on, this answer included: live
        stream, 3D view, REST. `{}` ends it. Streams are ordered, so nothing is lost: a lost packet is sent again, and
        what follows it waits."""
        try:
            settings = LinkSettings(
                1e-3 * change.delay_ms,
                1e-3 * change.jitter_ms,
                loss=1e-2 * change.loss_percent,
                rate_bps=None if change.rate_mbit is None else 1e6 * change.rate_mbit,
            )
        except ValueError as failure:
            raise Problem(422, "invalid-request", f"The link cannot be so: {failure}.") from None
        link.change(settings)
        return Json(link.report())

    return router
