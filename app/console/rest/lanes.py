"""The past of the lanes."""

from __future__ import annotations

import asyncio
from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import Response

from app.console.live.hub import Hub
from app.console.live.lane_history import SPAN_S
from app.console.problems import Problem
from app.console.records.lanes import LanesPast
from app.console.rest.answers import Json, problems
from app.console.rest.routing import router as api_router
from app.runtime.clock import Clock

MOST_POINTS = 1200


def lanes_router(hub: Hub, clock: Clock) -> APIRouter:
    """Route of ``/lanes``."""
    router = api_router("attention")

    @router.get("/lanes", response_model=LanesPast, summary="What the lanes were", responses=problems(422))
    async def get_lanes(
        begin: Annotated[
            float | None,
            Query(alias="from", allow_inf_nan=False, description="Robot's clock (s); by default an hour before `to`."),
        ] = None,
        end: Annotated[
            float | None, Query(alias="to", allow_inf_nan=False, description="Robot's clock (s); by default now.")
        ] = None,
        points: Annotated[int, Query(ge=1, le=MOST_POINTS, description="At most so many buckets.")] = 600,
    ) -> Response:
        """The last hour is kept, twice a second, and of a recording what was played. Where that is more than `points`
        it is put into buckets of equal width; a closing shorter than a bucket stays among the `changes`."""
        until = clock.now() if end is None else end
        since = until - SPAN_S if begin is None else begin
        if since > until:
            message = f"{since} is after to, {until}"
            raise Problem(422, "invalid-request", f"from: {message}", errors=[("query.from", message)])
        stretch = hub.lanes.between(since, until)
        # Of an eventful hour it is a tenth of a second's work.
        return await asyncio.to_thread(lambda: Json(stretch.in_buckets(points)))

    return router
