"""One operation as a request, and its answer: pure, for both robots."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote, urlsplit, urlunsplit

import httpx
import msgspec

BASE = "/api/v1"
#: Seconds for an answer, beside what the program is asked to wait.
PATIENCE_S = 30.0


class Problem(Exception):
    """A refusal, as the program words it (RFC 9457).

    ``kind``: the last part of its type, for example ``no-such-desire``. ``errors``: what is wrong, member by member.
    """

    def __init__(self, status: int, kind: str, detail: str, errors: list[tuple[str, str]]) -> None:
        super().__init__(f"{detail} ({kind}, {status})")
        self.status = status
        self.kind = kind
        self.detail = detail
        self.errors = errors


class Unreachable(ConnectionError):
    """The console does not answer: it does not run, or not there."""


@dataclass(frozen=True)
class Request:
    """``method`` and ``path`` below ``/api/v1``; ``answer``: the type of what is answered.

    Members of ``query`` and ``headers`` that are None are left out.
    """

    method: str
    path: str
    answer: Any
    body: Any = None
    media: str = "application/json"
    query: Mapping[str, Any] = field(default_factory=dict)
    headers: Mapping[str, str | None] = field(default_factory=dict)

    @staticmethod
    def quoted(part: str | int) -> str:
        """``part`` as one segment of a path."""
        return quote(str(part), safe="")

    def options(self) -> dict[str, Any]:
        """As httpx takes it."""
        headers = {name: value for name, value in self.headers.items() if value is not None}
        content = None
        if self.body is not None:
            content = _content(self.body)
            headers["Content-Type"] = self.media
        wait = float(self.query.get("wait") or 0.0)
        return {
            "method": self.method,
            "url": BASE + self.path,
            "params": {name: value for name, value in self.query.items() if value is not None},
            "headers": headers,
            "content": content,
            "timeout": PATIENCE_S + wait,
        }

    def decoded(self, response: httpx.Response) -> Any:
        """What ``response`` says. Raises Problem for a refusal."""
        if response.status_code >= 400:
            raise problem_of(response.status_code, response.content)
        if self.answer is None or response.status_code == 204:
            return None
        if self.answer is bytes:
            return response.content
        if self.answer is str:
            return response.text
        return msgspec.json.decode(response.content, type=self.answer, strict=False)


def _content(body: Any) -> bytes:
    if isinstance(body, bytes):
        return body
    return body.encode() if isinstance(body, str) else msgspec.json.encode(body)


class _Field(msgspec.Struct):
    field: str = ""
    message: str = ""


class _Document(msgspec.Struct):
    type: str = ""
    title: str = ""
    detail: str = ""
    errors: list[_Field] = []


def problem_of(status: int, content: bytes) -> Problem:
    """The refusal in an answer of ``status``; what is no problem document (a proxy's page) is named by the status."""
    try:
        document = msgspec.json.decode(content, type=_Document)
    except (msgspec.DecodeError, UnicodeDecodeError):
        document = _Document()
    kind = document.type.rpartition(":")[2] or "unknown"
    detail = document.detail or document.title or f"the answer has status {status}"
    return Problem(status, kind, detail, [(each.field, each.message) for each in document.errors])


def address_of(address: str | None) -> str:
    """``address``, or that in the environment (``HBBA_ADDRESS``), or this computer's. Raises ValueError for another."""
    found = (address or os.environ.get("HBBA_ADDRESS") or "http://127.0.0.1:8080").rstrip("/")
    if urlsplit(found).scheme not in ("http", "https"):
        raise ValueError(f"a console's address begins with http:// or https://, not {found!r}")
    return found


def headers_of(token: str | None, operator: str | None) -> dict[str, str]:
    """Who asks. ``token``: None: that of the environment (``HBBA_TOKEN``), if any; ``operator``: None: a program."""
    headers = {"Accept": "application/json, */*"}
    if token := token or os.environ.get("HBBA_TOKEN"):
        headers["Authorization"] = f"Bearer {token}"
    if operator:
        headers["X-HBBA-Operator"] = quote(operator, safe="")
    return headers


def with_cookies(headers: Mapping[str, str], cookies: httpx.Cookies) -> dict[str, str]:
    """``headers`` with the session's cookie, for the live stream."""
    joined = "; ".join(f"{name}={value}" for name, value in cookies.items())
    return {**headers, "Cookie": joined} if joined else dict(headers)


def live_url(address: str, operator: str | None) -> str:
    """The live stream's address of the console at ``address``."""
    parts = urlsplit(address)
    scheme = {"http": "ws", "https": "wss"}[parts.scheme]
    query = f"operator={quote(operator, safe='')}" if operator else ""
    return urlunsplit((scheme, parts.netloc, f"{BASE}/live", query, ""))
