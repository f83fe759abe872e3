"""What the robot sees and hears, now."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from app.console.perceived import perceived_json
from app.console.percepts import Percepts
from app.console.records.percepts import PerceptsModel
from app.console.rest.answers import Json
from app.console.rest.routing import router as api_router
from app.runtime.clock import Clock


def percepts_router(percepts: Percepts, clock: Clock) -> APIRouter:
    """Routes of ``/percepts``."""
    router = api_router("robot")

    @router.get("/percepts", response_model=PerceptsModel, summary="Faces, sounds, loud noises, codes")
    async def get_percepts() -> Response:
        """The same as `perceived` on the live stream. What attention has closed is not perceived."""
        return Json(perceived_json(percepts.at(clock.now())))

    return router
