"""A picture or a video of a tour as an answer."""

from __future__ import annotations

from fastapi.responses import FileResponse

from app.console.problems import Problem
from app.console.rest.answers import BYTES
from app.console.rest.download import check_range
from app.console.rest.tour_answers import on_disk
from app.tours.media import MediaLibrary
from app.tours.media_content import TYPES, TooLarge, kind_of_name

#: Its description.
MEDIA_FILE = {"content": {kind: {"schema": BYTES} for kind in sorted(set(TYPES.values()))}, "description": "The file."}
_HEADERS = {
    "Cache-Control": "private, max-age=300",
    # It is no page where it is opened by itself.
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; sandbox",
}


async def media_answer(media: MediaLibrary, file: str, asked: str | None) -> FileResponse:
    """The file that tours call ``file``, or the part ``asked`` for in the header ``Range``.

    Raises Problem where there is none, and for one that is larger than phones are given.
    """
    path, status = await on_disk(media.find, file)
    kind = kind_of_name(file)
    assert kind is not None
    try:
        kind.check_size(status.st_size)
    except TooLarge as refusal:
        raise Problem(409, "media-too-large", f"{file} {refusal}.") from None
    if asked is not None:
        check_range(asked, status.st_size)
    return FileResponse(path, media_type=kind.type, stat_result=status, headers=_HEADERS)
