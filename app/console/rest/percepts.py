"""What the robot sees and hears, now."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import Response

from app.console import reports
from app.console.rest.answers import Json
from app.console.rest.routing import router as api_router
from app.messages import PlacedPercepts

if TYPE_CHECKING:
    from app.program.system import System


def percepts_router(system: System) -> APIRouter:
    """Routes of ``/percepts``."""
    router = api_router("robot")

    @router.get("/percepts", response_model=PlacedPercepts, summary="Faces, sounds, loud noises, codes")
    async def get_percepts() -> Response:
        """The same as `perceived` on the live stream. What attention has closed is not perceived."""
        percepts = reports.latest(system.graph, "placed_percepts")
        return Json(percepts or PlacedPercepts(system.clock.now()))

    return router
