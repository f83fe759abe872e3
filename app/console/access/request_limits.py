"""Limits of a request's size: its header and its body, counted before anything else looks at them.

Every body is read here, up to the limit, before the request goes on: by its size as it arrives, not by what the header
says of it.
"""

from __future__ import annotations

from collections.abc import Iterable

from starlette.datastructures import Headers
from starlette.types import Message, Receive, Scope

from app.console.problems import Problem

LARGEST_BODY_BYTES = 65_536
LARGEST_HEADER_BYTES = 32_768
LARGEST_TARGET_BYTES = 8_192
MOST_FIELDS = 100
#: As much of a body that is too large is read and thrown away, so that the refusal can be read at the other end.
DRAINED_BYTES = 1024 * 1024

_CLOSE = {"Connection": "close"}


class ClientLeft(Exception):
    """The connection ended before the whole body was there: no answer is awaited."""


def objection_to_header(target: bytes, fields: Iterable[tuple[bytes, bytes]]) -> Problem | None:
    """Why a request with this target (path and query) and these header fields is not read, or None."""
    sizes = [len(name) + len(value) + 4 for name, value in fields]
    if len(target) > LARGEST_TARGET_BYTES:
        detail = f"A path with its query has at most {LARGEST_TARGET_BYTES} bytes here, not {len(target)}."
        return Problem(414, "address-too-long", detail, headers=_CLOSE)
    if len(sizes) > MOST_FIELDS:
        detail = f"A request has at most {MOST_FIELDS} header fields here, not {len(sizes)}."
        return Problem(431, "header-too-large", detail, headers=_CLOSE)
    if sum(sizes) > LARGEST_HEADER_BYTES:
        detail = f"A request's header has at most {LARGEST_HEADER_BYTES} bytes here, not {sum(sizes)}."
        return Problem(431, "header-too-large", detail, headers=_CLOSE)
    return None


def objection_to_scope(scope: Scope) -> Problem | None:
    """:func:`objection_to_header`, of an ASGI scope."""
    target = scope.get("raw_path") or scope["path"].encode()
    return objection_to_header(target + b"?" + scope["query_string"], scope["headers"])


async def with_body(headers: Headers, receive: Receive) -> Receive:
    """Read a request's body; gives what the application is to receive instead.

    Raises Problem for one that is too large or of two sizes at once (RFC 9112, section 6.3: a request that two readers
    may understand in two ways), ClientLeft when the connection ends before it is whole.
    """
    length, chunked = headers.get("content-length"), "transfer-encoding" in headers
    if length is not None and chunked:
        detail = "A request states its body's size by Content-Length or by Transfer-Encoding, not by both."
        raise Problem(400, "ambiguous-body", detail, headers=_CLOSE)
    if length is None and not chunked:
        return receive
    if length is not None and length.isdecimal() and int(length) > DRAINED_BYTES:
        raise _too_large(length, close=True)
    read, parts = 0, list[bytes]()
    more = True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ClientLeft
        part, more = message.get("body", b""), message.get("more_body", False)
        read += len(part)
        if read <= LARGEST_BODY_BYTES:
            parts.append(part)
        elif read > DRAINED_BYTES:
            raise _too_large("more", close=True)
        else:
            parts.clear()
    if read > LARGEST_BODY_BYTES:
        raise _too_large(str(read), close=False)
    body: Message | None = {"type": "http.request", "body": b"".join(parts), "more_body": False}

    async def receive_read() -> Message:
        nonlocal body
        if body is None:
            return await receive()
        whole, body = body, None
        return whole

    return receive_read


def _too_large(size: str, *, close: bool) -> Problem:
    detail = f"A body has at most {LARGEST_BODY_BYTES} bytes here, not {size}."
    return Problem(413, "body-too-large", detail, headers=_CLOSE if close else {})
