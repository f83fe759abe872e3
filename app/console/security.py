"""Who may talk to the console, and from which page.

On loopback without a token anyone on this computer may, but a web page elsewhere may not: the ``Host`` must be a name
of this computer (DNS rebinding), and where a browser states an ``Origin``, it must be ours. Beyond loopback a token is
needed, as ``Authorization: Bearer`` or, for browsers, as a cookie had for it at ``/api/v1/session``.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.console.problems import MEDIA_TYPE, Problem, problem_body
from app.errors import ConfigError

COOKIE = "hbba_session"
SHORTEST_TOKEN = 8
LARGEST_BODY_BYTES = 65_536
#: What may be reached without having logged in, besides the page itself: the login and the sign of life.
OPEN_PATHS = frozenset({"/api/v1/health", "/api/v1/session"})
GUARDED = ("/api", "/viser")

_PAGE_POLICY = (
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self'; "
    "object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'self'"
)
# viser's client is one file that unpacks and runs itself, with workers and WebAssembly.
_VIEW_POLICY = (
    "default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "style-src 'self' 'unsafe-inline'; worker-src 'self' blob: data:; connect-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)


def is_loopback(host: str) -> bool:
    """Whether ``host`` (a name or an address, without port) is this computer itself."""
    if host.lower().rstrip(".") == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def new_token() -> str:
    """A token to print at the start: 128 random bits."""
    return secrets.token_urlsafe(16)


def check_token(token: str | None, host: str) -> str | None:
    """The token to use on ``host``. Raises ConfigError for one that is missing or too short."""
    if token is not None and len(token) < SHORTEST_TOKEN:
        raise ConfigError(f"the console's token must have at least {SHORTEST_TOKEN} characters, not {len(token)}")
    if token is None and not is_loopback(host):
        raise ConfigError(f"{host} can be reached by others: the console needs a token there")
    return token


class Door:
    """Tells who may enter. ``token`` None: whoever is on this computer."""

    def __init__(self, token: str | None) -> None:
        self._token = token
        # The cookie proves knowledge of the token without holding it, and survives a restart with the same one.
        self._cookie = (
            None
            if token is None
            else hmac.new(token.encode(), b"hbba console session, version 1", hashlib.sha256).hexdigest()
        )

    @property
    def cookie(self) -> str | None:
        """The cookie of a browser that has logged in; None where no login is needed."""
        return self._cookie

    def opens_to(self, token: str) -> bool:
        """Whether ``token`` is the right one (compared in constant time)."""
        return self._token is None or hmac.compare_digest(self._token.encode(), token.encode())

    def knows(self, headers: Headers) -> bool:
        """Whether a request carries the token or the cookie."""
        if self._cookie is None:
            return True
        scheme, _, bearer = headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer":
            return self.opens_to(bearer.strip())
        return hmac.compare_digest(self._cookie, _cookie_value(headers))

    def objection(self, scope: Scope) -> Problem | None:
        """Why a request or a WebSocket is refused, or None."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self._token is None and not is_loopback(_host_name(host)):
            return Problem(
                421,
                "wrong-host",
                f"This console answers to localhost and 127.0.0.1 only, not to {host or 'a request without a Host'}; "
                "to reach it from elsewhere, start it with --host and a token.",
            )
        origin = headers.get("origin")
        changes = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD", "OPTIONS")
        if changes and origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return Problem(403, "foreign-origin", f"Pages of {origin} may not use this console.")
        if scope["type"] == "http" and (problem := _objection_to_body(headers)) is not None:
            return problem
        path = scope["path"]
        guarded = any(path == prefix or path.startswith(f"{prefix}/") for prefix in GUARDED)
        # The session's own GET answers 401 by itself, so that a page can ask whether it must log in.
        if guarded and path not in OPEN_PATHS and not self.knows(headers):
            return unauthorized()
        return None


def _objection_to_body(headers: Headers) -> Problem | None:
    """Why a body is not read: nothing here takes a large one, nor one of unknown size."""
    length = headers.get("content-length")
    if length is None:
        if "transfer-encoding" not in headers:
            return None
        return Problem(411, "length-required", "State the body's size in Content-Length.")
    if length.isdecimal() and int(length) > LARGEST_BODY_BYTES:
        return Problem(413, "body-too-large", f"A body has at most {LARGEST_BODY_BYTES} bytes here, not {length}.")
    return None


def unauthorized() -> Problem:
    """The refusal of who has not logged in."""
    return Problem(
        401,
        "login-needed",
        "This console needs its token: as `Authorization: Bearer ...`, or log in at POST /api/v1/session.",
        headers={"WWW-Authenticate": 'Bearer realm="hbba"'},
    )


def _host_name(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookie_value(headers: Headers) -> str:
    try:
        morsel = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    # compare_digest takes ASCII only.
    return morsel.value if morsel is not None and morsel.value.isascii() else ""


class Guarded:
    """ASGI middleware: asks the door, and gives every answer its security headers."""

    def __init__(self, app: ASGIApp, door: Door) -> None:
        self._app = app
        self._door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with why not."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        problem = self._door.objection(scope)
        if scope["type"] == "websocket":
            if problem is None:
                await self._app(scope, receive, send)
            else:
                await _refuse_websocket(problem, scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                add_headers(MutableHeaders(scope=message), scope["path"])
            await send(message)

        if problem is None:
            await self._app(scope, receive, send_with_headers)
            return
        body = problem_body(problem)
        fields = {"content-type": MEDIA_TYPE, "content-length": str(len(body))} | problem.headers
        raw = [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in fields.items()]
        await send_with_headers({"type": "http.response.start", "status": problem.status, "headers": raw})
        await send_with_headers({"type": "http.response.body", "body": body})


async def _refuse_websocket(problem: Problem, scope: Scope, receive: Receive, send: Send) -> None:
    await receive()
    if "websocket.http.response" not in scope.get("extensions", {}):
        await send({"type": "websocket.close", "code": 1008, "reason": problem.detail})
        return
    headers = [(b"content-type", MEDIA_TYPE.encode())]
    headers += [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in problem.headers.items()]
    await send({"type": "websocket.http.response.start", "status": problem.status, "headers": headers})
    await send({"type": "websocket.http.response.body", "body": problem_body(problem)})


def add_headers(headers: MutableHeaders, path: str) -> None:
    """Set the security and cache headers of an answer at ``path``; what is set already stays."""
    headers.setdefault("x-content-type-options", "nosniff")
    headers.setdefault("referrer-policy", "same-origin")
    headers.setdefault("cross-origin-opener-policy", "same-origin")
    headers.setdefault("cross-origin-resource-policy", "same-origin")
    headers.setdefault("content-security-policy", _VIEW_POLICY if path.startswith("/viser") else _PAGE_POLICY)
    if path.startswith("/assets/"):
        # Vite names these by their content.
        headers.setdefault("cache-control", "public, max-age=31536000, immutable")
    else:
        headers.setdefault("cache-control", "no-store" if path.startswith("/api") else "no-cache")
