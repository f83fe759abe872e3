"""Limits of a request's size: its header and its body, counted before anything else looks at them.

A body is read here, up to the limit, before the request goes on: by its size as it arrives, not by what the header
says of it. A document that may be larger than most is read here as well, but only once the door has let the request in.
A file that is handed in is too large for that: its route reads it as it comes, then too, and counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

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
#: In the scope of a request whose body is a file that may come for longer than others.
_STREAMED = "hbba.streamed"


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Greatest bodies (bytes), by method and path, where they are not ``LARGEST_BODY_BYTES``: of ``streamed`` requests,
    whose routes read files as they come, and of ``whole`` ones, which are read before. A ``*`` in a path of ``whole``
    is any one segment."""

    streamed: Mapping[tuple[str, str], int]
    whole: Mapping[tuple[str, str], int] = field(default_factory=dict)

    def of_streamed(self, scope: Scope) -> int | None:
        """The limit of the request of ``scope``; None: its body is read like all others."""
        return self.streamed.get((scope["method"], scope["path"]))

    def of_whole(self, scope: Scope) -> int | None:
        """The limit of the request of ``scope``; None: that of most."""
        method, path = scope["method"], scope["path"].split("/")
        for (named, pattern), most in self.whole.items():
            parts = pattern.split("/")
            alike = len(parts) == len(path) and all(a in ("*", b) for a, b in zip(parts, path, strict=True))
            if named == method and alike:
                return most
        return None


def is_streamed(scope: Mapping[str, Any]) -> bool:
    """Whether a body may take its time: it was let in by :func:`counted`."""
    return scope.get(_STREAMED) is True


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


async def with_body(headers: Headers, receive: Receive, most: int = LARGEST_BODY_BYTES) -> Receive:
    """Read a request's body of at most ``most`` bytes; gives what the application is to receive instead.

    Raises Problem for one that is too large or of two sizes at once (RFC 9112, section 6.3: a request that two readers
    may understand in two ways), ClientLeft when the connection ends before it is whole.
    """
    length = _length(headers)
    if length is None and "transfer-encoding" not in headers:
        return receive
    drained = max(DRAINED_BYTES, 2 * most)
    if length is not None and length.isdecimal() and int(length) > drained:
        raise _too_large(most, length, close=True)
    read, parts = 0, list[bytes]()
    more = True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ClientLeft
        part, more = message.get("body", b""), message.get("more_body", False)
        read += len(part)
        if read <= most:
            parts.append(part)
        elif read > drained:
            raise _too_large(most, "more", close=True)
        else:
            parts.clear()
    if read > most:
        raise _too_large(most, str(read), close=False)
    body: Message | None = {"type": "http.request", "body": b"".join(parts), "more_body": False}

    async def receive_read() -> Message:
        nonlocal body
        if body is None:
            return await receive()
        whole, body = body, None
        return whole

    return receive_read


def counted(scope: Scope, receive: Receive, most: int) -> Receive:
    """What a route receives instead, which reads a body of ``most`` bytes as it comes.

    It raises Problem for a body that is larger as it comes; this function for one that says so, or states two sizes.
    """
    length = _length(Headers(scope=scope))
    if length is not None and length.isdecimal() and int(length) > most:
        raise _too_large(most, length, close=True)
    scope[_STREAMED] = True
    read = 0

    async def receive_counted() -> Message:
        nonlocal read
        message = await receive()
        read += len(message.get("body", b""))
        if read > most:
            raise _too_large(most, "more", close=True)
        return message

    return receive_counted


def _length(headers: Headers) -> str | None:
    """What the header says of the body's size. Raises Problem for one of two sizes."""
    length = headers.get("content-length")
    if length is not None and "transfer-encoding" in headers:
        detail = "A request states its body's size by Content-Length or by Transfer-Encoding, not by both."
        raise Problem(400, "ambiguous-body", detail, headers=_CLOSE)
    return length


def _too_large(most: int, size: str, *, close: bool) -> Problem:
    detail = f"A body has at most {most} bytes here, not {size}."
    return Problem(413, "body-too-large", detail, headers=_CLOSE if close else {})
