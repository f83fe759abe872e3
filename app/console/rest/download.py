"""A file as an answer: whole or in part, read piece by piece in a thread."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

from fastapi import Request
from fastapi.responses import FileResponse

from app.console.problems import Problem

#: Registered with IANA.
MCAP = "application/vnd.mcap"
_RANGES = re.compile(r"bytes\s*=\s*(\d+-\d*|-\d+)(\s*,\s*(\d+-\d*|-\d+))*\s*", re.IGNORECASE)


class Download(FileResponse):
    """An MCAP file to be saved under its own name."""

    @classmethod
    async def of(cls, path: Path, request: Request) -> Download:
        """The answer to ``request`` for the file at ``path``.

        Raises FileNotFoundError, and Problem for a range that the file does not have, in place of Starlette's own
        refusals, which are no problem documents.
        """
        status = await asyncio.to_thread(path.stat)
        given = request.headers.get("range")
        if given is not None:
            _check_range(given, status.st_size)
        return cls(path, filename=path.name, media_type=MCAP, stat_result=status)


def _check_range(given: str, size: int) -> None:
    refusal = Problem(
        416,
        "range-not-satisfiable",
        f"The file has {size} bytes; ask for a part of it as `Range: bytes=0-99`, not {given}.",
        headers={"Content-Range": f"bytes */{size}"},
    )
    if _RANGES.fullmatch(given) is None:
        raise refusal
    for part in given.partition("=")[2].split(","):
        first, _, last = (piece.strip() for piece in part.partition("-"))
        begin = int(first) if first else max(size - int(last), 0)
        if begin >= size or (first and last and int(last) < begin):
            raise refusal
