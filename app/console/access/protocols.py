"""uvicorn's two protocols, with an end to connections that are only held.

uvicorn bounds the time between two requests and what waits to be read or written. Added here: the time a header and a
body may take, and reading an answer; how many connections there may be (:mod:`app.console.access.connection_limits`);
and one line in the log where uvicorn writes a traceback for what a client sent.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from app.console.access.connection_limits import Visitors
from app.console.access.request_limits import is_streamed, objection_to_header
from app.console.problems import MEDIA_TYPE, Problem, problem_body

HEADER_WITHIN_S = 10.0
BODY_WITHIN_S = 20.0
#: A file that is handed in has a second more for each of so many bytes.
SLOWEST_FILE_BYTES_PER_S = 100_000
#: An answer of which nothing more is taken for so long is given up; sooner, while there is no room for others.
STALLED_AFTER_S = 60.0
WAITS_AFTER_S = 5.0
#: A connection being closed has this long (s) to take the last message.
LINGER_S = 5.0

_BUSY = Problem(
    503,
    "too-many-connections",
    "There are too many connections to this console now.",
    headers={"Retry-After": "5", "Connection": "close"},
)
_SLOW_HEADER = Problem(
    408,
    "too-slow",
    f"A request's header has to be whole within {HEADER_WITHIN_S:g} s.",
    headers={"Connection": "close"},
)
_SLOW_BODY = Problem(
    408, "too-slow", f"A request's body must be whole within {BODY_WITHIN_S:g} s.", headers={"Connection": "close"}
)


class BoundedHttp(H11Protocol):
    """HTTP/1.1 on one connection."""

    def __init__(self, *args: Any, visitors: Visitors, **options: Any) -> None:
        super().__init__(*args, **options)
        self._visitors = visitors
        self._phase = ""
        self._deadline: asyncio.TimerHandle | None = None
        self._stalled: asyncio.TimerHandle | None = None
        self._stalled_since: float | None = None
        self._body_began = 0.0
        self._body_bytes = 0

    @property
    def address(self) -> str:
        return address_of_peer(self.transport)

    @property
    def waits(self) -> bool:
        """Whether it has nothing to be served, or does not take it."""
        if self._stalled_since is not None:
            return self.loop.time() - self._stalled_since >= WAITS_AFTER_S
        return self._phase != "answer"

    def give_way(self) -> None:
        self.transport.abort()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if self._visitors.enter(self):
            self._look()
        else:
            self._refuse(_BUSY)

    def connection_lost(self, exc: Exception | None) -> None:
        self._visitors.leave(self)
        self._cancel_timers()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._look()
        self._body_bytes += len(data)  # those with the header, too

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._visitors.served(self)
        self._look()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._stalled_since = self.loop.time()
        self._stalled = self.loop.call_later(STALLED_AFTER_S, self.give_way)

    def resume_writing(self) -> None:
        super().resume_writing()
        self._stalled_since = None
        if self._stalled is not None:
            self._stalled.cancel()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        if (problem := objection_to_header(event.target, self.headers)) is not None:
            self._refuse(problem)
            return
        self._cancel_timers()
        super().handle_websocket_upgrade(event)

    def send_400_response(self, msg: str) -> None:
        """Refuse what is no HTTP; called where h11 has just raised."""
        error = sys.exc_info()[1]
        status = error.error_status_hint if isinstance(error, h11.RemoteProtocolError) else 400
        kinds = {431: "header-too-large", 501: "unknown-transfer-encoding"}
        detail = f"This is no request that HTTP/1.1 allows: {error}." if error is not None else msg
        self._refuse(Problem(status, kinds.get(status, "malformed-request"), detail, headers={"Connection": "close"}))

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _look(self) -> None:
        """Give the phase that the connection is in now its time."""
        ours, theirs = self.conn.our_state, self.conn.their_state
        if self.transport.get_protocol() is not self:
            return  # a WebSocket now
        if self.transport.is_closing():
            self._enter("close", LINGER_S, self.give_way)
        elif theirs is h11.SEND_BODY:
            self._enter("body", BODY_WITHIN_S, self._end_of_body)
        elif ours is not h11.IDLE or theirs is not h11.IDLE:
            self._enter("answer", None, self.give_way)
        elif self.timeout_keep_alive_task is not None:
            # uvicorn closes it; but what was not taken yet would keep it open.
            self._enter("idle", self.timeout_keep_alive + LINGER_S, self.give_way)
        else:
            self._enter("header", HEADER_WITHIN_S, lambda: self._too_slow(_SLOW_HEADER))

    def _enter(self, phase: str, within_s: float | None, act: Callable[[], None]) -> None:
        if phase == self._phase:
            return
        self._phase = phase
        self._body_began, self._body_bytes = self.loop.time(), 0
        if self._deadline is not None:
            self._deadline.cancel()
        self._deadline = None if within_s is None else self.loop.call_later(within_s, act)

    def _end_of_body(self) -> None:
        """The time of a body is over, or that of a file goes on."""
        left_s = 0.0
        if is_streamed(self.scope):
            given_s = BODY_WITHIN_S + self._body_bytes / SLOWEST_FILE_BYTES_PER_S
            left_s = self._body_began + given_s - self.loop.time()
        if left_s > 0:
            self._deadline = self.loop.call_later(left_s, self._end_of_body)
        else:
            self._too_slow(_SLOW_BODY)

    def _too_slow(self, problem: Problem) -> None:
        asked = bool(self.conn.trailing_data[0]) if self._phase == "header" else not self.cycle.response_started
        if not asked:
            self.transport.close()
        else:
            self._refuse(problem)
        self._look()

    def _refuse(self, problem: Problem) -> None:
        """Answer past the application, and close."""
        self.transport.write(_raw(problem))
        self.transport.close()
        self._look()

    def _cancel_timers(self) -> None:
        for timer in (self._deadline, self._stalled):
            if timer is not None:
                timer.cancel()


class BoundedWebSocket(WebSocketsSansIOProtocol):
    def __init__(self, *args: Any, visitors: Visitors, **options: Any) -> None:
        super().__init__(*args, **options)
        self._visitors = visitors

    @property
    def address(self) -> str:
        return address_of_peer(self.transport)

    @property
    def waits(self) -> bool:
        """Never: it was let in, and a ping finds out whether the client is still there."""
        return False

    def give_way(self) -> None:
        self.transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        http = transport.get_protocol()
        super().connection_made(transport)
        if isinstance(http, BoundedHttp) and not self._visitors.becomes_socket(http, self):
            self.app = _refuses

    def connection_lost(self, exc: Exception | None) -> None:
        self._visitors.leave(self)
        super().connection_lost(exc)

    async def send(self, message: Any) -> None:
        await super().send(message)
        if message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            # uvicorn takes a refusal in words for a handshake that was left out, and logs an error.
            self.handshake_complete = True

    def keepalive_timeout(self) -> None:
        """Pings are not answered: what is still to be sent, which a mere close waits for, will not be taken either."""
        super().keepalive_timeout()
        self.loop.call_later(LINGER_S, self.give_way)

    def send_receive_event_to_app(self) -> None:
        if self.curr_msg_data_type == "text" and not self.close_sent:
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError as error:
                self.logger.warning("a WebSocket of %s sent a text that is not UTF-8: closed", self.address)
                self.frames = []
                self.conn.send_close(1007, f"not UTF-8 at byte {error.start}")
                self.handle_parser_exception()
                return
        super().send_receive_event_to_app()


async def _refuses(scope: Any, receive: Any, send: Any) -> None:
    """An application that refuses a WebSocket for want of room."""
    await receive()
    headers = [(b"content-type", MEDIA_TYPE.encode()), (b"retry-after", b"5")]
    await send({"type": "websocket.http.response.start", "status": _BUSY.status, "headers": headers})
    await send({"type": "websocket.http.response.body", "body": problem_body(_BUSY)})


def address_of_peer(transport: asyncio.BaseTransport) -> str:
    """The address at the other end of a connection, without its port; "" where that is no longer known."""
    peer = transport.get_extra_info("peername")
    return str(peer[0]) if isinstance(peer, tuple) and peer else ""


def _raw(problem: Problem) -> bytes:
    """The whole answer as it goes over the wire."""
    body = problem_body(problem)
    fields = {"Content-Type": MEDIA_TYPE, "Content-Length": str(len(body)), "X-Content-Type-Options": "nosniff"}
    lines = [
        f"HTTP/1.1 {problem.status} {HTTPStatus(problem.status).phrase}",
        *(f"{n}: {v}" for n, v in (fields | problem.headers).items()),
    ]
    return "\r\n".join([*lines, "", ""]).encode("latin-1") + body
