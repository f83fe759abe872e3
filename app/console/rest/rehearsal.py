"""Rehearsals of tours: started, followed, cancelled; one at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import Field

from app.console.problems import Problem
from app.console.records.tours import RehearsalReport
from app.console.rehearsal_process import RehearsalOrder
from app.console.rehearsals import Rehearsals, RehearsalUnderWay
from app.console.rest.answers import Json, problems
from app.console.rest.models import Request
from app.console.rest.routing import router as api_router
from app.console.rest.tour_answers import TourId, on_disk
from app.tours.tour_file import tour_text
from app.tours.values import Language

if TYPE_CHECKING:
    from app.program.system import System


class NewRehearsal(Request):
    """How a tour is rehearsed."""

    language: Language | None = Field(None, description="Of the visitors; left out: the tour's first.")
    people: int = Field(2, ge=0, le=8, description="How many visitors follow.")
    seed: int = Field(1, ge=0, lt=2**31, description="Of how they follow: the same again with the same.")


def rehearsal_router(system: System, rehearsals: Rehearsals) -> APIRouter:
    """Routes of ``/tour-rehearsal``."""
    router = api_router("tours")

    @router.post(
        "/tours/{tour_id}/rehearsal",
        response_model=RehearsalReport,
        status_code=202,
        summary="Rehearse a tour",
        responses=problems(400, 404, 409, 422),
    )
    async def start_rehearsal(tour_id: TourId, how: NewRehearsal) -> Response:
        """Plays the tour as it is kept on its map, without the robot, in a process of its own: the robot may be driven
        meanwhile. Follow it by `GET /tour-rehearsal`."""
        tour = (await on_disk(system.tours.get, tour_id)).tour
        language = how.language or tour.languages[0]
        if language not in tour.languages:
            words = f"the tour {tour_id} is not in {language!r}; there are: {', '.join(tour.languages)}"
            raise Problem(422, "invalid-request", f"{words[0].upper()}{words[1:]}.", errors=[("language", words)])
        order = RehearsalOrder(
            tour_text(tour),
            str(system.config.program_document.file),
            str(system.maps.folder),
            language=language,
            people=how.people,
            seed=how.seed,
        )
        try:
            rehearsals.start(tour_id, order)
        except RehearsalUnderWay as refusal:
            words = str(refusal)
            raise Problem(409, "rehearsal-under-way", f"{words[0].upper()}{words[1:]}.") from None
        return Json(rehearsals.report, status_code=202)

    @router.get("/tour-rehearsal", response_model=RehearsalReport, summary="The rehearsal under way, or the last")
    async def get_rehearsal() -> Response:
        """How far it is; once it is `done`, what was said and done when, where the robot was, and what went wrong."""
        return Json(rehearsals.report)

    @router.delete("/tour-rehearsal", status_code=204, summary="Cancel the rehearsal, or forget it")
    async def cancel_rehearsal() -> Response:
        """There is none afterwards; also where there was none."""
        await rehearsals.cancel()
        return Response(status_code=204)

    return router
