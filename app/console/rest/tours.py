"""Guided tours: listed, edited by several people at once, checked, undone, exchanged as files, printed as posters."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from fastapi import APIRouter, Body, Path, Query, Request
from fastapi.responses import Response

from app.base.errors import ConfigError
from app.base.merge_patch import merged
from app.base.named_library import NAME
from app.console.problems import Problem
from app.console.records.tours import TourList, TourProblemReport, TourReport, TourSummary, TourVerdict
from app.console.rest.answers import BYTES, Json, problems
from app.console.rest.entity_tags import IfMatch, check_match, etag, tagged, with_etag
from app.console.rest.routing import router as api_router
from app.program.recognizer import recognizer_of
from app.tours.checks import check
from app.tours.consistency import tour_of
from app.tours.library import NoVersion, ShippedTour, TooManyTours, TourError, TourTaken, UnknownTour
from app.tours.model import Tour, tour_schema
from app.tours.paper import Paper
from app.tours.problems import InvalidTour, TourProblem
from app.tours.store import KeptTour
from app.tours.surroundings import surroundings
from app.tours.tour_file import read_tour, tour_text
from app.tours.values import Language

if TYPE_CHECKING:
    from app.program.system import System

T = TypeVar("T")
YAML, PDF = "application/yaml", "application/pdf"
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

TourId = Annotated[
    str, Path(description="The tour's id.", examples=["lab-tour"], json_schema_extra={"pattern": f"^{NAME.pattern}$"})
]
TourBody = Annotated[
    dict[str, Any], Body(description="A tour, as `GET /tour-schema` describes it.", examples=[EXAMPLE])
]
_LOCATION: dict[str, Any] = {"Location": {"schema": {"type": "string"}, "description": "Where the tour is."}}
_CREATED: dict[int | str, dict[str, Any]] = {201: {"description": "It was created.", "headers": _LOCATION}}
_GONE: dict[int | str, dict[str, Any]] = {204: {"description": "There was no such tour at that time: it is gone."}}


def tours_router(system: System) -> APIRouter:
    """Routes of ``/tours``."""
    router = api_router("tours")
    store = system.tours
    recognizer = recognizer_of(system.config)

    @router.get("/tours", response_model=TourList, summary="List all tours", responses=problems(409))
    async def list_tours() -> Response:
        """By id, those that come with the program among them; each with its `etag`."""
        return Json(await on_disk(listing))

    @router.post(
        "/tours",
        response_model=TourReport,
        status_code=201,
        summary="Create a tour",
        responses=with_etag({201: {"headers": _LOCATION}, **problems(400, 409, 422)}, 201),
    )
    async def create_tour(new: TourBody) -> Response:
        """Under the id in it. What it refers to need not exist yet: the `problems` say what it lacks to run."""
        return await _answer(store.create, _tour(new), status=201)

    @router.post("/tours/validate", response_model=TourVerdict, summary="Check a tour", responses=problems(400, 422))
    async def validate_tour(draft: TourBody) -> Response:
        """Without keeping it. Every mistake is found, with what else it lacks to run on this robot."""
        return Json(await on_disk(verdict, draft))

    @router.post(
        "/tours/import",
        response_model=TourReport,
        status_code=201,
        summary="Import a tour's file",
        responses=with_etag(with_etag({**_CREATED, **problems(409, 412, 422)}), 201),
        openapi_extra={"requestBody": {"required": True, "content": {YAML: {"schema": {"type": "string"}}}}},
    )
    async def import_tour(request: Request, if_match: IfMatch = None) -> Response:
        """YAML, as `GET /tours/{tour_id}/file` gives it, under the id in it. With `If-Match` it replaces the tour of
        this id (200); without, that is refused."""
        body = await request.body()

        def read() -> Tour:
            try:
                return read_tour(body.decode("utf-8"), "the file")[0]
            except UnicodeDecodeError:
                raise _no_tour("body", "the file is not a text in UTF-8") from None
            except ConfigError as mistake:
                raise _no_tour(mistake.key or "body", str(mistake), line=mistake.line) from None

        tour = await asyncio.to_thread(read)
        if if_match is None:
            return await _answer(store.create, tour, status=201)
        return await _answer(store.replace, tour, matching(if_match))

    @router.get("/tour-schema", summary="The JSON Schema of a tour")
    async def get_tour_schema() -> Response:
        """Draft 2020-12. What it cannot say, `POST /tours/validate` finds."""
        return Json(tour_schema())

    @router.get(
        "/tours/{tour_id}", response_model=TourReport, summary="One tour", responses=with_etag(problems(404, 409, 422))
    )
    async def get_tour(tour_id: TourId) -> Response:
        return await _answer(store.get, tour_id)

    @router.put(
        "/tours/{tour_id}",
        response_model=TourReport,
        summary="Replace a tour, or create it under this id",
        responses={**with_etag(problems(400, 409, 412, 422)), **with_etag(_CREATED, 201)},
    )
    async def replace_tour(tour_id: TourId, new: TourBody, if_match: IfMatch = None) -> Response:
        """The id in it may be left out. With `If-Match`, nothing is created."""
        tour = _tour({"id": tour_id, **new})
        _same_id(tour_id, tour)
        try:
            return await _answer(store.replace, tour, matching(if_match))
        except Problem as problem:
            if problem.kind != "no-such-tour":
                raise
        if if_match is not None:
            raise Problem(412, "changed-meanwhile", f"There is no tour {tour_id} any more: nothing was done.")
        return await _answer(store.create, tour, status=201)

    @router.patch(
        "/tours/{tour_id}",
        response_model=TourReport,
        summary="Change a tour",
        responses=with_etag(problems(400, 404, 409, 412, 422)),
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
            result = _tour(merged(version(tour), change))
            _same_id(tour_id, result)
            return result

        return await _answer(store.edit, tour_id, changed)

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
        return await _answer(lambda: store.undo(tour_id, matching(if_match), to_begin=to_begin))

    @router.post(
        "/tours/{tour_id}/redo",
        response_model=TourReport,
        summary="Do again what was undone last",
        responses={**with_etag(problems(404, 409, 412, 422)), **_GONE},
    )
    async def redo_tour(tour_id: TourId, if_match: IfMatch = None) -> Response:
        """Needs no body."""
        return await _answer(store.redo, tour_id, matching(if_match))

    @router.get(
        "/tours/{tour_id}/file",
        response_class=Response,
        summary="Export a tour's file",
        responses={
            200: {"content": {YAML: {"schema": {"type": "string"}}}, "description": "YAML."},
            **problems(404, 409, 422),
        },
    )
    async def export_tour(tour_id: TourId) -> Response:
        """Without pictures and videos."""
        kept = await on_disk(store.get, tour_id)
        named = {"Content-Disposition": f'attachment; filename="{tour_id}.yaml"'}
        return Response(tour_text(kept.tour), media_type=YAML, headers=named)

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

    def listing() -> TourList:
        return TourList(str(store.library.folder), tuple(map(summary, store.names())))

    def summary(name: str) -> TourSummary:
        try:
            kept = store.get(name)
        except (ConfigError, ValueError) as damage:
            return damaged(name, str(damage))
        tour = kept.tour
        severities = [problem.severity for problem in checked(tour)]
        return TourSummary(
            id=tour.id,
            title=tour.title,
            languages=tour.languages,
            map=tour.map,
            stops=sum(not stop.left_out for stop in tour.stops),
            shipped=kept.shipped,
            etag=etag(version(tour)),
            errors=severities.count("error"),
            warnings=severities.count("warning"),
            problem=None,
        )

    def verdict(draft: dict[str, Any]) -> TourVerdict:
        try:
            found = checked(tour_of(draft))
        except InvalidTour as refusal:
            found = refusal.problems
        return TourVerdict(all(problem.severity == "warning" for problem in found), _reports(found))

    def checked(tour: Tour) -> tuple[TourProblem, ...]:
        folders = store.library.folders
        around = surroundings(tour, maps=system.maps, folders=folders, classes=system.classes, recognizer=recognizer)
        return check(tour, around)

    def matching(if_match: str | None) -> Callable[[Tour], None]:
        return lambda tour: check_match(if_match, version(tour))

    async def _answer(change: Callable[..., KeptTour | None], *args: Any, status: int = 200) -> Response:
        """What ``change`` leads to, as an answer."""

        def report() -> TourReport | None:
            if (kept := change(*args)) is None:
                return None
            found = _reports(checked(kept.tour))
            return TourReport(version(kept.tour), kept.shipped, kept.can_undo, kept.can_redo, found)

        found = await on_disk(report)
        if found is None:
            return Response(status_code=204)
        headers = {"Location": f"/api/v1/tours/{found.tour['id']}"} if status == 201 else {}
        return tagged(found, version=found.tour, status=status, headers=headers)

    return router


def version(tour: Tour) -> dict[str, Any]:
    """All of ``tour``, as it is sent and as its tag is made of."""
    return tour.model_dump(mode="json", by_alias=True)


def damaged(name: str, problem: str) -> TourSummary:
    """The summary of a file that is no tour."""
    return TourSummary(
        id=name,
        title={},
        languages=(),
        map="",
        stops=0,
        shipped=False,
        etag="",
        errors=0,
        warnings=0,
        problem=problem,
    )


async def on_disk(function: Callable[..., T], *args: Any) -> T:
    """``function(*args)`` of the store, in a thread. Raises Problem."""
    try:
        return await asyncio.to_thread(function, *args)
    except (TourError, ConfigError, OSError) as refusal:
        raise _problem(refusal) from None
    except InvalidTour as refusal:
        raise _invalid(refusal) from None
    except ValueError as refusal:
        raise Problem(422, "invalid-name", f"{refusal}.", errors=[("path.tour_id", str(refusal))]) from None


def _problem(refusal: Exception) -> Problem:
    match refusal:
        case UnknownTour():
            return Problem(404, "no-such-tour", f"{refusal}.")
        case TourTaken():
            return Problem(409, "tour-exists", f"{refusal}.", errors=[("id", str(refusal))])
        case ShippedTour():
            return Problem(409, "tour-shipped", f"{refusal}.")
        case TooManyTours():
            return Problem(409, "too-many-tours", f"{refusal}.")
        case NoVersion():
            return Problem(409, "no-other-version", f"{refusal}.")
        case OSError():
            where = f"{refusal.filename}: " if refusal.filename else ""
            return Problem(409, "disk-refuses", f"The disk refuses: {where}{refusal.strerror or refusal}.")
    return Problem(409, "unreadable-tour", f"The tour's file is damaged: {refusal}")


def _tour(data: dict[str, Any]) -> Tour:
    """The tour that ``data`` is. Raises Problem, which names every field that is wrong."""
    try:
        return tour_of(data)
    except InvalidTour as refusal:
        raise _invalid(refusal) from None


def _invalid(refusal: InvalidTour) -> Problem:
    return Problem(
        422,
        "invalid-tour",
        f"{refusal}.",
        errors=[(problem.field, problem.message) for problem in refusal.problems],
    )


def _no_tour(field: str, words: str, **more: Any) -> Problem:
    return Problem(422, "invalid-tour", f"{words}.", errors=[(field, words)], **more)


def _same_id(tour_id: str, tour: Tour) -> None:
    if tour.id != tour_id:
        message = f"should be {tour_id!r}: an id does not change; export the tour and import it under another id"
        raise _no_tour("id", f"id {message}")


def _reports(found: tuple[TourProblem, ...]) -> tuple[TourProblemReport, ...]:
    return tuple(TourProblemReport(problem.field, problem.message, problem.severity) for problem in found)
