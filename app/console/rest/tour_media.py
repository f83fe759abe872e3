"""Pictures and videos of tours: listed, handed in, shown, deleted."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response

from app.base.errors import ConfigError
from app.console.access.request_limits import BodyLimits
from app.console.problems import Problem
from app.console.records.tours import TourMedia, TourMediaList
from app.console.rest.answers import BYTES, Json, problems
from app.console.rest.media_answer import MEDIA_FILE, media_answer
from app.console.rest.routing import API
from app.console.rest.routing import router as api_router
from app.console.rest.tour_answers import on_disk
from app.console.rest.upload import SLOW, partial_file, write_body
from app.tours import archive
from app.tours.checks import media_of
from app.tours.media import MediaFile
from app.tours.media_content import (
    HEAD_BYTES,
    LARGEST_PICTURE_BYTES,
    LARGEST_VIDEO_BYTES,
    TYPES,
    NotShown,
    TooLarge,
    kind_of_head,
)
from app.tours.tour_file import MOST_BYTES

if TYPE_CHECKING:
    from app.program.system import System

#: Bodies that are files, read as they come, and tours as JSON.
LIMITS = BodyLimits(
    {("POST", f"{API}/tour-media"): LARGEST_VIDEO_BYTES, ("POST", f"{API}/tours/import"): archive.LARGEST_BYTES},
    {
        ("POST", f"{API}/tours"): MOST_BYTES,
        ("POST", f"{API}/tours/validate"): MOST_BYTES,
        ("PUT", f"{API}/tours/*"): MOST_BYTES,
        ("PATCH", f"{API}/tours/*"): MOST_BYTES,
    },
)
#: So many files come at once; others wait until one is there.
UPLOADS_AT_ONCE = 3

_LOCATION = {"Location": {"schema": {"type": "string"}, "description": "Where it is."}}
_LARGE: dict[int | str, dict[str, Any]] = {413: {"description": "A picture has at most 20 MB, a video 500 MB."}}
_SLOW: dict[int | str, dict[str, Any]] = {
    408: {"description": "A file comes at 100 kB/s at least, after its first 20 s."}
}
_TAKEN: dict[str, Any] = {
    "required": True,
    "content": {kind: {"schema": BYTES} for kind in sorted(set(TYPES.values()))},
}

MediaName = Annotated[str, Path(description="As tours name it.", examples=["media/arm.jpg"])]


def tour_media_router(system: System) -> APIRouter:
    """Routes of ``/tour-media``."""
    router = api_router("tours")
    store = system.tours
    media = store.media
    room = asyncio.Semaphore(UPLOADS_AT_ONCE)

    @router.get(
        "/tour-media",
        response_model=TourMediaList,
        summary="List pictures and videos of tours",
        responses=problems(409),
    )
    async def list_tour_media() -> Response:
        """All that tours can show, by name, with the tours that do."""

        def listing() -> TourMediaList:
            used = _used()
            files = tuple(_described(each, used.get(each.file, ())) for each in media.listing())
            return TourMediaList(files, LARGEST_PICTURE_BYTES, LARGEST_VIDEO_BYTES)

        return Json(await on_disk(listing))

    @router.post(
        "/tour-media",
        response_model=TourMedia,
        status_code=201,
        summary="Hand in a picture or a video",
        responses={
            200: {"description": "It was there already, under this name."},
            201: {"headers": _LOCATION},
            **_LARGE,
            **SLOW,
            **problems(400, 409, 422, 507),
        },
        openapi_extra={"requestBody": _TAKEN},
    )
    async def add_tour_media(
        request: Request,
        name: Annotated[str, Query(min_length=1, max_length=200, description="Its name where it comes from.")],
    ) -> Response:
        """The file itself is the body. What it is, its content says: JPEG, PNG, WebP, GIF, MP4 or WebM, and whole.
        `file` of the answer is what a tour's `show` names it: made of `name`, with a number where another has it."""

        def look(head: bytes, size: int) -> None:
            kind_of_head(head[:HEAD_BYTES]).check_size(size)

        async with room:
            try:
                async with partial_file(media, _size_of(request)) as partial:
                    await write_body(request, partial, look)
                    kept, is_new = await on_disk(media.keep, partial, name)
            except TooLarge as refusal:
                raise Problem(413, "media-too-large", f"{name} {refusal}.", errors=[("body", str(refusal))]) from None
            except NotShown as refusal:
                raise Problem(422, "invalid-media", f"{name} {refusal}.", errors=[("body", str(refusal))]) from None
        used = await asyncio.to_thread(_used)
        headers = {"Location": f"{API}/tour-media/{kept.file}"} if is_new else {}
        return Json(_described(kept, used.get(kept.file, ())), 201 if is_new else 200, headers=headers)

    @router.get(
        "/tour-media/{file:path}",
        response_class=Response,
        summary="A picture or a video",
        responses={200: MEDIA_FILE, **problems(404, 409, 416)},
    )
    async def get_tour_media(file: MediaName, request: Request) -> Response:
        """Whole, or in part (`Range`)."""
        return await media_answer(media, file, request.headers.get("range"))

    @router.delete(
        "/tour-media/{file:path}", status_code=204, summary="Delete a picture or a video", responses=problems(404, 409)
    )
    async def delete_tour_media(file: MediaName) -> Response:
        """For good; `undo` of a tour does not bring it back. One that a tour shows is not deleted."""

        def delete() -> None:
            media.find(file)
            if users := _used().get(file):
                words = f"{file} is shown by {', '.join(users)}"
                raise Problem(409, "media-in-use", f"{words}; take it out there first.", tours=list(users))
            media.delete(file)

        await on_disk(delete)
        return Response(status_code=204)

    def _used() -> dict[str, tuple[str, ...]]:
        """Ids of the tours that show each file."""
        used: dict[str, tuple[str, ...]] = {}
        for name in store.names():
            try:
                tour = store.get(name).tour
            except (ConfigError, ValueError):
                continue  # the list of tours says what is wrong with it
            for file in dict.fromkeys(file for _, file in media_of(tour)):
                used[file] = (*used.get(file, ()), name)
        return used

    return router


def _size_of(request: Request) -> int:
    """What the header says of the body's size (bytes)."""
    length = request.headers.get("content-length", "")
    return int(length) if length.isdecimal() else 0


def _described(found: MediaFile, tours: tuple[str, ...]) -> TourMedia:
    return TourMedia(
        file=found.file,
        type=found.kind.type,
        video=found.kind.is_video,
        size=found.size,
        changed=found.changed,
        shipped=found.shipped,
        tours=tours,
    )
