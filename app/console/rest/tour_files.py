"""Guided tours as files that are exchanged: YAML alone, or with pictures and videos in a ZIP archive."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, Request
from fastapi.responses import Response, StreamingResponse

from app.base.errors import ConfigError
from app.console.problems import Problem
from app.console.records.tours import TourReport
from app.console.rest.answers import BYTES, problems
from app.console.rest.entity_tags import IfMatch, with_etag
from app.console.rest.routing import router as api_router
from app.console.rest.tour_answers import TourAnswers, TourId, matching, no_tour, on_disk
from app.console.rest.tours import CREATED
from app.console.rest.upload import SLOW, partial_file, write_body
from app.tours.archive import SIGNATURE, packed, unpacked
from app.tours.model import Tour
from app.tours.store import KeptTour
from app.tours.tour_file import MOST_BYTES, read_tour, tour_text

if TYPE_CHECKING:
    from app.program.system import System

YAML, ZIP = "application/yaml", "application/zip"

_TAKEN = {"required": True, "content": {YAML: {"schema": {"type": "string"}}, ZIP: {"schema": BYTES}}}
_LARGE: dict[int | str, dict[str, Any]] = {413: {"description": "YAML has at most 1 MB, an archive 2 GiB."}}
_SLOW: dict[int | str, dict[str, Any]] = {
    408: {"description": "A file comes at 100 kB/s at least, after its first 20 s."}
}


def tour_files_router(system: System) -> APIRouter:
    """Routes by which files of tours come and go; before those of ``/tours/{tour_id}``."""
    router = api_router("tours")
    store = system.tours
    answers = TourAnswers(system)

    @router.post(
        "/tours/import",
        response_model=TourReport,
        status_code=201,
        summary="Import a tour's file",
        responses=with_etag(
            with_etag({**CREATED, **_LARGE, **SLOW, **problems(400, 409, 412, 422, 507)}),
            201,
        ),
        openapi_extra={"requestBody": _TAKEN},
    )
    async def import_tour(request: Request, if_match: IfMatch = None) -> Response:
        """YAML, as `GET /tours/{tour_id}/file` gives it (or JSON, which is YAML), or the archive of `GET
        /tours/{tour_id}/archive`, under the id in it. With `If-Match` it replaces the tour of this id (200); without,
        that is refused. The media of an archive are kept with the tour or not at all; where another picture has a name,
        the tour names the new one."""

        def use(tour: Tour) -> KeptTour:
            return store.create(tour) if if_match is None else store.replace(tour, matching(if_match))

        def look(head: bytes, size: int) -> None:
            if size > MOST_BYTES and not head.startswith(SIGNATURE):
                detail = f"A tour's file has at most {MOST_BYTES // 1000} kB; with media, it is a ZIP archive."
                raise Problem(413, "body-too-large", detail)

        async with partial_file(store.media, 0) as partial:
            await write_body(request, partial, look)
            return await answers.answer(_imported, partial, use, status=201 if if_match is None else 200)

    def _imported(path: Path, use: Callable[[Tour], KeptTour]) -> KeptTour:
        with path.open("rb") as file:
            zipped = file.read(len(SIGNATURE)) == SIGNATURE
        try:
            if zipped:
                return unpacked(path, store.media, use)
            tour, _ = read_tour(path.read_bytes().decode("utf-8"), "the file")
        except UnicodeDecodeError:
            raise no_tour("body", "the file is not a text in UTF-8") from None
        except ConfigError as mistake:
            raise no_tour(mistake.key or "body", str(mistake), line=mistake.line) from None
        return use(tour)

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
        return Response(tour_text(kept.tour), media_type=YAML, headers=_named(f"{tour_id}.yaml"))

    @router.get(
        "/tours/{tour_id}/archive",
        response_class=Response,
        summary="Export a tour with its pictures and videos",
        responses={200: {"content": {ZIP: {"schema": BYTES}}, "description": "ZIP."}, **problems(404, 409, 422)},
    )
    async def export_tour_archive(tour_id: TourId) -> Response:
        """A ZIP archive of the tour's file and what it shows, without what is missing."""
        kept = await on_disk(store.get, tour_id)
        return StreamingResponse(packed(kept.tour, store.media), media_type=ZIP, headers=_named(f"{tour_id}.zip"))

    return router


def _named(file: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{file}"'}
