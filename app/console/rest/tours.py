"""Guided tours: listed, edited by several people at once, checked, undone, printed as posters."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Query
from fastapi.responses import Response

from app.base.merge_patch import merged
from app.console.problems import Problem
from app.console.records.tours import TourList, TourReport, TourVerdict
from app.console.rest.answers import BYTES, Json, problems
from app.console.rest.entity_tags import IfMatch, check_match, with_etag
from app.console.rest.routing import router as api_router
from app.console.rest.tour_answers import TourAnswers, TourId, matching, no_tour, on_disk, tour_from, version
from app.tours.model import Tour, tour_schema
from app.tours.paper import Paper
from app.tours.values import Language

if TYPE_CHECKING:
    from app.program.system import System

PDF = "application/pdf"
EXAMPLE = {
    "format": 1,
    "id": "lab-tour",
    "title": {"en": "The robotics lab"},
    "languages": ["en"],
    "map": "lab",
    "stops": [
        {
            "id": "arm",
            "place": "robotics-lab",
            "title": {"en": "The arm"},
            "do": [{"say": {"en": "It yields when pushed."}, "point": [11.1, 9.1, 1.2]}],
        }
    ],
}

TourBody = Annotated[
    dict[str, Any], Body(description="A tour, as `GET /tour-schema` describes it.", examples=[EXAMPLE])
]
LOCATION: dict[str, Any] = {"Location": {"schema": {"type": "string"}, "description": "Where the tour is."}}
CREATED: dict[int | str, dict[str, Any]] = {201: {"description": "It was created.", "headers": LOCATION}}
#: As MOST_BYTES of a tour's file.
_LARGE: dict[int | str, dict[str, Any]] = {413: {"description": "A tour has at most 1 MB."}}
_GONE: dict[int | str, dict[str, Any]] = {204: {"description": "There was no such tour at that time: it is gone."}}


def tours_router(system: System) -> APIRouter:
    """Routes of ``/tours``."""
    router = api_router("tours")
    store = system.tours
    answers = TourAnswers(system)

    @router.get("/tours", response_model=TourList, summary="List all tours", responses=problems(409))
    async def list_tours() -> Response:
        """By id, those that come with the program among them; each with its `etag`."""
        return Json(await on_disk(answers.listing))

    @router.post(
        "/tours",
        response_model=TourReport,
        status_code=201,
        summary="Create a tour",
        responses=with_etag({201: {"headers": LOCATION}, **_LARGE, **problems(400, 409, 422)}, 201),
    )
    async def create_tour(new: TourBody) -> Response:
        """Under the id in it. What it refers to need not exist yet: the `problems` say what it lacks to run."""
        return await answers.answer(store.create, tour_from(new), status=201)

    @router.post(
        "/tours/validate",
        response_model=TourVerdict,
        summary="Check a tour",
        responses={**_LARGE, **problems(400, 422)},
    )
    async def validate_tour(draft: TourBody) -> Response:
        """Without keeping it. Every mistake is found, with what else it lacks to run on this robot."""
        return Json(await on_disk(answers.verdict, draft))

    @router.get("/tour-schema", summary="The JSON Schema of a tour")
    async def get_tour_schema() -> Response:
        """Draft 2020-12. What it cannot say, `POST /tours/validate` finds."""
        return Json(tour_schema())

    @router.get(
        "/tours/{tour_id}", response_model=TourReport, summary="One tour", responses=with_etag(problems(404, 409, 422))
    )
    async def get_tour(tour_id: TourId) -> Response:
        return await answers.answer(store.get, tour_id)

    @router.put(
        "/tours/{tour_id}",
        response_model=TourReport,
        summary="Replace a tour, or create it under this id",
        responses={**with_etag({**_LARGE, **problems(400, 409, 412, 422)}), **with_etag(CREATED, 201)},
    )
    async def replace_tour(tour_id: TourId, new: TourBody, if_match: IfMatch = None) -> Response:
        """The id in it may be left out. With `If-Match`, nothing is created."""
        tour = tour_from({"id": tour_id, **new})
        _same_id(tour_id, tour)
        try:
            return await answers.answer(store.replace, tour, matching(if_match))
        except Problem as problem:
            if problem.kind != "no-such-tour":
                raise
        if if_match is not None:
            raise Problem(412, "changed-meanwhile", f"There is no tour {tour_id} any more: nothing was done.")
        return await answers.answer(store.create, tour, status=201)

    @router.patch(
        "/tours/{tour_id}",
        response_model=TourReport,
        summary="Change a tour",
        responses=with_etag({**_LARGE, **problems(400, 404, 409, 412, 422)}),
    )
    async def change_tour(
        tour_id: TourId,
        change: Annotated[dict[str, Any], Body(examples=[{"pace": {"speed": 0.6}, "home": None}])],
        if_match: IfMatch = None,
    ) -> Response:
        """A JSON Merge Patch (RFC 7396): members left out stay, null gives a member its usual value, a list is replaced
        as a whole. An id does not change."""

        def changed(tour: Tour) -> Tour:
            check_match(if_match, version(tour))
            result = tour_from(merged(version(tour), change))
            _same_id(tour_id, result)
            return result

        return await answers.answer(store.edit, tour_id, changed)

    @router.delete("/tours/{tour_id}", status_code=204, summary="Delete a tour", responses=problems(404, 409, 412, 422))
    async def delete_tour(tour_id: TourId, if_match: IfMatch = None) -> Response:
        """`POST /tours/{tour_id}/undo` brings it back until the program ends. Where it was a changed tour of the
        program's, that one is there again; the program's own are not deleted."""
        await on_disk(store.delete, tour_id, matching(if_match))
        return Response(status_code=204)

    @router.post(
        "/tours/{tour_id}/undo",
        response_model=TourReport,
        summary="Undo the newest change of a tour",
        responses={**with_etag(problems(404, 409, 412, 422)), **_GONE},
    )
    async def undo_tour(
        tour_id: TourId,
        if_match: IfMatch = None,
        to_begin: Annotated[bool, Query(description="All changes since the program began.")] = False,
    ) -> Response:
        """Anyone's, since the program began: edits, deletion, import, and what a text editor changed in the file. Needs
        no body."""
        return await answers.answer(lambda: store.undo(tour_id, matching(if_match), to_begin=to_begin))

    @router.post(
        "/tours/{tour_id}/redo",
        response_model=TourReport,
        summary="Do again what was undone last",
        responses={**with_etag(problems(404, 409, 412, 422)), **_GONE},
    )
    async def redo_tour(tour_id: TourId, if_match: IfMatch = None) -> Response:
        """Needs no body."""
        return await answers.answer(store.redo, tour_id, matching(if_match))

    @router.get(
        "/tours/{tour_id}/posters.pdf",
        response_class=Response,
        summary="Print posters",
        responses={
            200: {"content": {PDF: {"schema": BYTES}}, "description": "PDF, one poster a page."},
            **problems(404, 409, 422),
        },
    )
    async def get_tour_posters(
        tour_id: TourId,
        paper: Annotated[Paper, Query(description="A4 or US Letter.")] = "a4",
        language: Annotated[Language | None, Query(description="Of the titles; left out: the tour's first.")] = None,
        stop: Annotated[str | None, Query(max_length=100, description="Id of one stop; left out: all.")] = None,
    ) -> Response:
        """Of the stops that have the text of a `poster`."""
        kept = await on_disk(store.get, tour_id)

        def printed() -> bytes:
            from app.tours.posters import NoPosters, posters_of, posters_pdf  # loads matplotlib

            try:
                posters = posters_of(kept.tour, language, None if stop is None else [stop])
            except NoPosters as refusal:
                raise Problem(409, "no-posters", f"{refusal}.") from None
            return posters_pdf(posters, paper, kept.tour.title.get(language or "", tour_id))

        return Response(await asyncio.to_thread(printed), media_type=PDF)

    return router


def _same_id(tour_id: str, tour: Tour) -> None:
    if tour.id != tour_id:
        message = f"should be {tour_id!r}: an id does not change; export the tour and import it under another id"
        raise no_tour("id", f"id {message}")
