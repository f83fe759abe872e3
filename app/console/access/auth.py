"""Authorization: who may use the console, and from which page.

On loopback without a token anyone on this computer may, but a web page elsewhere may not: the ``Host`` must be a name
of this computer (DNS rebinding), and where a browser states an ``Origin``, it must be ours. Beyond loopback a token is
needed, or the password of a role, as ``Authorization: Bearer`` or, for browsers, as the cookie of a session from
``/api/v1/session``; the ``Host`` must then be an address, this computer's name, or one that the console was started
for. The second port, that of the 3D view, asks the same, and takes the session's cookie of the first.

What a client may do once it is in, its role says (:mod:`app.console.access.roles`): that of the password, a
supervisor's with the token, and where no login is asked for.

Visitors of a tour have neither: the key of its run opens what is below VISITOR_PATHS to them, and nothing else.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import socket
import time
from collections.abc import Callable, Collection
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.console.access.credentials import Credentials
from app.console.access.headers import add_headers
from app.console.access.identity import LOCAL, VISITOR, Identity, note_identity, require
from app.console.access.login_check import LoginCheck
from app.console.access.origins import Ports, host_name, scheme_of
from app.console.access.request_limits import BodyLimits, ClientLeft, counted, objection_to_scope, with_body
from app.console.access.roles import SOCKETS, Role
from app.console.access.sessions import LoginSession, Sessions
from app.console.access.visitor_keys import VisitorKeys
from app.console.problems import MEDIA_TYPE, Problem, problem_body, problem_response

COOKIE = "hbba_session"
VISITOR_COOKIE = "hbba_visitor"
#: All that a visitor's cookie opens; browsers send it nowhere else.
VISITOR_PATHS = "/api/v1/visitor/"
#: Paths that may be reached without a login, besides the pages: both logins and the sign of life.
OPEN_PATHS = frozenset({"/api/v1/health", "/api/v1/session", f"{VISITOR_PATHS}session", "/viser/health"})
GUARDED = ("/api", "/viser", "/panels")


def is_loopback(host: str) -> bool:
    """Whether ``host`` (a name or an address, without port) is this computer itself."""
    if host.lower().rstrip(".") == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


class Door:
    """Decides which requests are let in, and as whom. ``credentials`` without any: those from this computer.

    ``names`` are host names that this console answers to beyond addresses and this computer's own name; ``ports`` are
    where it listens, if the 3D view has one of its own; ``now`` gives seconds of any steady clock.
    """

    def __init__(
        self,
        credentials: Credentials,
        names: Collection[str] = (),
        *,
        ports: Ports | None = None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.ports = ports
        self.credentials = credentials
        self._names = frozenset(name.lower().rstrip(".") for name in (*names, *own_names()))
        self._sessions = Sessions(now)
        self._check = LoginCheck(credentials, now)
        #: Of the tour that is led.
        self.visitors = VisitorKeys(now)

    @property
    def asks(self) -> bool:
        """Whether a login is needed."""
        return self.credentials.asked

    async def log_in(self, secret: str, scope: Scope) -> tuple[str | None, Role]:
        """Begin a session by the token or a password; returns its cookie, None where none is needed, and its role.

        Raises Problem for a wrong one."""
        if not self.asks:
            return None, Role.SUPERVISOR
        role = await self._check.role_of(secret, _address(scope))
        return self._sessions.begin(role), role

    def log_out(self, scope: Scope) -> None:
        """End the session that a request belongs to, and its connections."""
        self._sessions.end(self._cookie(scope))

    def session(self, scope: Scope) -> LoginSession | None:
        """The session that a request belongs to; None without one, as where it brings the token itself."""
        return self._sessions.find(self._cookie(scope)) if self.asks else None

    def visitor(self, scope: Scope) -> LoginSession | None:
        """The session of the visitor who makes a request; None for all others, and for all that is not visitors'."""
        if not scope["path"].startswith(VISITOR_PATHS):
            return None
        return self.visitors.find(HTTPConnection(scope).cookies.get(cookie_name(scope, VISITOR_COOKIE)))

    async def admit(self, scope: Scope) -> Identity:
        """Who makes a request, by what it brings: a session's cookie, or the token or a password. Raises Problem."""
        if not self.asks:
            return LOCAL
        if (session := self.session(scope)) is not None:
            assert session.role is not None
            return Identity(session.role, session.key)
        scheme, _, bearer = Headers(scope=scope).get("authorization", "").partition(" ")
        if scheme.lower() != "bearer":
            raise unauthorized()
        try:
            role = await self._check.role_of(bearer.strip(), _address(scope))
        except Problem as refusal:
            raise (unauthorized() if refusal.status == 401 else refusal) from None
        return Identity(role, f"bearer {role}")

    async def enter(self, scope: Scope) -> None:
        """Let a request or a WebSocket in, and note in ``scope`` as whom. Raises Problem for one that is refused."""
        if (problem := self.objection(scope)) is not None:
            raise problem
        path = scope["path"]
        guarded = any(path == prefix or path.startswith(f"{prefix}/") for prefix in GUARDED)
        # The session's own GET answers 401 by itself, so that a page can ask whether it must log in.
        if not guarded or path in OPEN_PATHS:
            return
        identity = VISITOR if self.visitor(scope) is not None else await self.admit(scope)
        note_identity(scope, identity)
        if scope["type"] == "websocket":
            require(identity, SOCKETS.get(path, Role.SUPERVISOR), path)

    def objection(self, scope: Scope) -> Problem | None:
        """Why a request or a WebSocket is refused for where it comes from alone; None: it is not."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if (problem := self._objection_to_host(host)) is not None:
            return problem
        origin = headers.get("origin")
        changes = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD", "OPTIONS")
        if changes and origin is not None and origin.lower() != f"{scheme_of(scope)}://{host}".lower():
            return Problem(403, "foreign-origin", f"Pages of {origin} may not use this console.")
        return None

    def _cookie(self, scope: Scope) -> str | None:
        at_scene = self.ports is not None and self.ports.at_scene(scope)
        name = f"{COOKIE}_{self.ports.page}" if self.ports is not None and at_scene else cookie_name(scope)
        return HTTPConnection(scope).cookies.get(name)

    def _objection_to_host(self, host: str) -> Problem | None:
        name = host_name(host)
        if is_loopback(name) or (self.asks and (_is_address(name) or name in self._names)):
            return None
        asked = host or "a request without a Host"
        if not self.asks:
            detail = (
                f"This console answers to localhost and 127.0.0.1 only, not to {asked}; "
                "to reach it from elsewhere, start it with --host and a token."
            )
        else:
            detail = (
                f"This console answers to its addresses and its computer's own name, not to {asked}; "
                "to reach it under another name, start it with --host-name NAME."
            )
        return Problem(421, "wrong-host", detail)


def unauthorized() -> Problem:
    """The refusal of who has not logged in."""
    return Problem(
        401,
        "login-needed",
        "This console needs its token, or the password of a role: as `Authorization: Bearer ...`, or log in at "
        "POST /api/v1/session.",
        headers={"WWW-Authenticate": 'Bearer realm="hbba"'},
    )


def _address(scope: Scope) -> str:
    return scope["client"][0] if scope.get("client") else ""


def own_names() -> tuple[str, ...]:
    """The names under which this computer knows itself, and mDNS knows it."""
    name = socket.gethostname().lower()
    first = name.partition(".")[0]
    return (name, first, f"{first}.local") if first else ()


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def cookie_name(scope: Scope, cookie: str = COOKIE) -> str:
    """The name of a session's cookie, one per port: browsers send a cookie to every port of a host, where the consoles
    of replays may be."""
    server = scope.get("server")
    return f"{cookie}_{server[1]}" if server else cookie


def cookie_fields(scope: Scope, path: str = "/") -> dict[str, Any]:
    """How a session's cookie for ``path`` is set and deleted: for no script, no other site, and, over TLS, for TLS
    alone."""
    return {"httponly": True, "samesite": "strict", "path": path, "secure": scheme_of(scope) == "https"}


class Guarded:
    """ASGI middleware: asks the door, reads bodies, and gives every answer its security headers.

    It must be the outermost layer, so that an answer to an error of the program has them too.
    """

    def __init__(self, app: ASGIApp, door: Door, limits: BodyLimits) -> None:
        self._app = app
        self._door = door
        self._limits = limits

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with why not."""
        if scope["type"] == "websocket":
            await self._websocket(scope, receive, send)
        elif scope["type"] == "http":
            await self._http(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                add_headers(MutableHeaders(scope=message), scope, self._door.ports)
            await send(message)

        try:
            if (problem := objection_to_scope(scope)) is not None:
                raise problem
            streamed, whole = self._limits.of_streamed(scope), self._limits.of_whole(scope)
            if streamed is None and whole is None:
                receive = await with_body(Headers(scope=scope), receive)
            await self._door.enter(scope)
            if streamed is not None:
                receive = counted(scope, receive, streamed)
            elif whole is not None:
                receive = await with_body(Headers(scope=scope), receive, whole)
        except ClientLeft:
            return
        except Problem as refusal:
            await problem_response(refusal)(scope, receive, send_with_headers)
            return
        await self._app(scope, receive, send_with_headers)

    async def _websocket(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            if (problem := objection_to_scope(scope)) is not None:
                raise problem
            await self._door.enter(scope)
        except Problem as refusal:
            await _refuse_websocket(refusal, scope, receive, send)
            return
        if (session := self._door.visitor(scope) or self._door.session(scope)) is not None:
            await _within(session, self._app, scope, receive, send)
        else:
            await self._app(scope, receive, send)


async def _within(session: LoginSession, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
    """Serve a WebSocket until it or its session ends."""
    closing: asyncio.Task[None] | None = None

    async def close() -> None:
        # The page may have closed it itself just now.
        with contextlib.suppress(OSError, RuntimeError):
            await send({"type": "websocket.close", "code": 1008, "reason": "logged out"})

    def end() -> None:
        nonlocal closing
        closing = asyncio.create_task(close(), name="log out")

    async def receive_in_session() -> Message:
        message = await receive()
        return message if closing is None else {"type": "websocket.disconnect", "code": 1008}

    async def send_in_session(message: Message) -> None:
        if closing is not None:
            raise OSError("the session has ended")
        await send(message)

    release = session.hold(end)
    try:
        await app(scope, receive_in_session, send_in_session)
    finally:
        release()
        if closing is not None:
            closing.cancel()
            await asyncio.wait({closing})


async def _refuse_websocket(problem: Problem, scope: Scope, receive: Receive, send: Send) -> None:
    await receive()
    if "websocket.http.response" not in scope.get("extensions", {}):
        await send({"type": "websocket.close", "code": 1008, "reason": problem.detail})
        return
    headers = [(b"content-type", MEDIA_TYPE.encode())]
    headers += [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in problem.headers.items()]
    await send({"type": "websocket.http.response.start", "status": problem.status, "headers": headers})
    await send({"type": "websocket.http.response.body", "body": problem_body(problem)})
