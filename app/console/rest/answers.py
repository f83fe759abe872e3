"""Answers encoded once, and the problems that a route may answer with, for the OpenAPI description."""

from __future__ import annotations

import gzip
from typing import Any

from fastapi import Request
from fastapi.responses import Response

from app.console.page import accepts
from app.console.problems import MEDIA_TYPE
from app.console.wire import encode

#: Of an answer that is a file.
BYTES = {"type": "string", "format": "binary"}


class Json(Response):
    """``content`` as JSON, by the same fast path as the live stream."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Encode ``content``; None is an empty body."""
        return b"" if content is None else encode(content)


#: What is smaller stays as it is.
_PACKED_FROM_BYTES = 2048


def packed(answer: Json, request: Request) -> Json:
    """``answer`` in gzip where the client of ``request`` takes that: a tenth of many records that are alike. Takes a
    millisecond for 50 kB; for a worker thread."""
    if len(answer.body) >= _PACKED_FROM_BYTES and accepts(request.headers.get("accept-encoding", ""), "gzip"):
        answer.body = gzip.compress(bytes(answer.body), compresslevel=5, mtime=0)
        answer.headers["Content-Encoding"] = "gzip"
        answer.headers["Content-Length"] = str(len(answer.body))
    answer.headers["Vary"] = "Accept-Encoding"
    return answer


_WORDS = {
    400: "The body is not JSON.",
    401: "The console's token, or the password of a role, is needed.",
    404: "There is no such thing.",
    409: "It cannot be done now.",
    412: "It was changed since: it is another version than `If-Match` names. `ETag` is the present one.",
    416: "The file has no such part.",
    422: "Something in the request is not allowed; `errors` says which field.",
    429: "Too many wrong tokens came from this address; `Retry-After` says how many seconds to wait.",
    502: "What was started for it failed.",
    503: "Many passwords are being checked; `Retry-After` says how many seconds to wait.",
    504: "The robot's body did not confirm it in time.",
    507: "The disk did not take it.",
}


def problem_content() -> dict[str, Any]:
    """OpenAPI's description of a problem document as the content of an answer."""
    return {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """OpenAPI's description of these refusals."""
    return {status: {"description": _WORDS[status], "content": problem_content()} for status in statuses}
