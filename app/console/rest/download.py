"""A file as an answer: whole or in part, read piece by piece in a thread."""

from __future__ import annotations

import os
import re
from pathlib import Path

from fastapi.responses import FileResponse

from app.console.problems import Problem

#: Registered with IANA.
MCAP = "application/vnd.mcap"
# No file has 10^18 bytes, and Python reads no number of thousands of digits.
_RANGE = r"(\d{1,18}-\d{0,18}|-\d{1,18})"
_RANGES = re.compile(rf"bytes\s*=\s*{_RANGE}(\s*,\s*{_RANGE})*\s*", re.IGNORECASE)


class Download(FileResponse):
    """An MCAP file to be saved under its own name."""

    @classmethod
    def of(cls, path: Path, status: os.stat_result, asked: str | None) -> Download:
        """The file at ``path``, whose ``status`` is known, or the part ``asked`` for in the header ``Range``.

        Raises Problem for a range that the file does not have, in place of Starlette's own refusals, which are no
        problem documents.
        """
        if asked is not None:
            check_range(asked, status.st_size)
        return cls(path, filename=path.name, media_type=MCAP, stat_result=status)


def check_range(asked: str, size: int) -> None:
    """Raises Problem unless a file of ``size`` bytes has the part ``asked`` for in the header ``Range``."""
    refusal = Problem(
        416,
        "range-not-satisfiable",
        f"The file has {size} bytes; ask for a part of it as `Range: bytes=0-99`, not {asked[:100]}.",
        headers={"Content-Range": f"bytes */{size}"},
    )
    if _RANGES.fullmatch(asked) is None:
        raise refusal
    for part in asked.partition("=")[2].split(","):
        first, _, last = (piece.strip() for piece in part.partition("-"))
        begin = int(first) if first else max(size - int(last), 0)
        if begin >= size or (first and last and int(last) < begin):
            raise refusal
