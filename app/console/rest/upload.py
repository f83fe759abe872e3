"""A body that is written to a file as it comes, its first bytes being looked at."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

from fastapi import Request
from starlette.requests import ClientDisconnect

from app.console.problems import Problem
from app.console.rest.tour_answers import on_disk
from app.tours.media import MediaLibrary

#: What OpenAPI says of a file that does not come.
SLOW: dict[int | str, dict[str, Any]] = {
    408: {"description": "A file comes at 100 kB/s at least, after its first 20 s."}
}
_PIECE = 1024**2


@contextlib.asynccontextmanager
async def partial_file(media: MediaLibrary, size: int) -> AsyncIterator[Path]:
    """:meth:`MediaLibrary.partial`, in threads. Raises Problem where there is no room."""
    partial = media.partial(size)
    path = await on_disk(partial.__enter__)
    try:
        yield path
    finally:
        await on_disk(partial.__exit__, None, None, None)


async def write_body(request: Request, path: Path, look: Callable[[bytes, int], None]) -> None:
    """Write the body of ``request`` to ``path``, piece by piece, in a thread.

    ``look`` is called with the first piece and the size so far (bytes), before each is written; what it raises ends it.
    Raises Problem where the body does not come whole or the disk refuses it.
    """
    waiting = bytearray()
    first = b""
    size = 0

    def write(piece: bytes) -> None:
        with path.open("ab") as file:
            file.write(piece)

    async def hand_on() -> None:
        nonlocal first, size
        piece = bytes(waiting)
        waiting.clear()
        first, size = first or piece, size + len(piece)
        look(first, size)
        await on_disk(write, piece)

    try:
        async for part in request.stream():
            waiting += part
            if len(waiting) >= _PIECE:
                await hand_on()
    except ClientDisconnect:
        raise Problem(400, "upload-cut-short", "The connection ended before the whole file was there.") from None
    await hand_on()
