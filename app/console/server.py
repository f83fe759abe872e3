"""Serving the console inside the running event loop."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import socket
import ssl
from collections.abc import Callable, Iterator
from functools import partial

import uvicorn
from starlette.types import ASGIApp

from app.base.errors import ConfigError
from app.console.access.connection_limits import Visitors, most_connections
from app.console.access.protocols import BoundedHttp, BoundedWebSocket
from app.console.access.request_limits import LARGEST_HEADER_BYTES
from app.console.tls import Handshakes

#: Connections still open this long after the end was asked for are cut.
GRACE_S = 0.3
#: Most of what is sent waits in our own outboxes, where newer replaces older, not in the kernel, where it goes stale.
UNSENT_BYTES = 64 * 1024
LARGEST_MESSAGE_BYTES = 1024 * 1024
#: Between two requests on a connection.
KEEP_ALIVE_S = 5
#: Without file descriptors, it is tried again after so long.
RETRY_S = 0.1
#: ... and they are enough again once none were wanting for so long.
CALM_AFTER_S = 10.0
#: Errors of Linux for one connection that failed before it was accepted (accept(2)).
_OF_ONE = (
    *(errno.EPERM, errno.EPROTO, errno.ENOPROTOOPT, errno.EHOSTDOWN, errno.EHOSTUNREACH),
    *(errno.ENETDOWN, errno.ENETUNREACH, errno.EOPNOTSUPP, errno.ETIMEDOUT),
)
_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

log = logging.getLogger("hbba.console")


def listen(host: str, port: int, option: str = "--port") -> socket.socket:
    """Bind ``host:port`` (port 0: any free one, which ``option`` chooses) and listen.

    To be done before anything else starts, so that nothing starts in vain. No request is answered before :func:`serve`.
    Raises ConfigError saying what to do when the address cannot be had, or connections to it could not.
    """
    most_connections()
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError as failure:
        raise ConfigError(f"the console cannot listen on {host}: {failure.strerror or failure}") from None
    listener = socket.socket(family, kind, protocol)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            # Connections inherit it.
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)
        listener.bind(address)
        listener.listen(128)
        listener.setblocking(False)
    except OSError as failure:
        listener.close()
        raise ConfigError(_why_not(host, port, option, failure)) from None
    return listener


def _why_not(host: str, port: int, option: str, failure: OSError) -> str:
    if failure.errno == errno.EADDRINUSE:
        return (
            f"port {port} of {host} is taken by another program; stop that one or choose another: "
            f"{option} {port + 1 if port < 65535 else 8080}, or {option} 0 for any free one"
        )
    if failure.errno == errno.EACCES:
        return f"port {port} needs more rights than this program has; choose one above 1023: {option} 8080"
    if failure.errno == errno.EADDRNOTAVAIL:
        return f"{host} is no address of this computer; use 127.0.0.1, or 0.0.0.0 for all its addresses"
    return f"the console cannot listen on {host}:{port}: {failure.strerror or failure}"


def listen_for_scene(host: str, page_port: int, port: int | None) -> socket.socket:
    """Listen on the second port, for the 3D view alone.

    ``port`` None: the one after ``page_port``, or any free one where that cannot be had. Raises ConfigError.
    """
    if port is None and page_port < 65535:
        with contextlib.suppress(ConfigError):  # what else than its being taken is wrong is said below
            return listen(host, page_port + 1, "--scene-port")
    if port == page_port:
        raise ConfigError(
            f"the 3D view needs a port of its own, not the page's {port}: choose another, or --scene-port 0 for any "
            "free one"
        )
    return listen(host, port or 0, "--scene-port")


def address_of(listener: socket.socket) -> tuple[str, int]:
    host, port = listener.getsockname()[:2]
    return str(host), int(port)


def url_of(listener: socket.socket, *, secure: bool = False) -> str:
    """The address to type into a browser on this computer; ``secure``: over TLS."""
    host, port = address_of(listener)
    if host in ("0.0.0.0", "::"):
        host = "127.0.0.1"
    scheme = "https" if secure else "http"
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"


class _Server(uvicorn.Server):
    """uvicorn without its signal handlers (the program has its own), with an end that never hangs. It accepts
    connections itself: asyncio logs a traceback thousands of times a second while there are no file descriptors."""

    def __init__(self, config: uvicorn.Config, visitors: Visitors, tls: ssl.SSLContext | None) -> None:
        super().__init__(config)
        self._visitors = visitors
        self._handshakes = None if tls is None else Handshakes(tls, self._protocol)
        self._accepting: list[asyncio.Task[None]] = []

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup([])
        self._accepting = [asyncio.create_task(self._accept(listener), name="accept") for listener in sockets or ()]
        for task in self._accepting:
            task.add_done_callback(self._accepting_ended)

    def failure(self) -> BaseException | None:
        """Why no connection is accepted any more, if that was not asked for."""
        ended = [task for task in self._accepting if task.done() and not task.cancelled()]
        return next((task.exception() for task in ended), None)

    async def _accept(self, listener: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        exhausted: float | None = None
        while True:
            try:
                connection, _ = await loop.sock_accept(listener)
                if self._handshakes is None:
                    await loop.connect_accepted_socket(self._protocol, connection)
                else:
                    self._handshakes.begin(connection)
            except OSError as failure:
                if isinstance(failure, ConnectionError) or failure.errno in _OF_ONE:
                    continue  # it left before it was let in
                if failure.errno not in _EXHAUSTED:
                    raise
                if exhausted is None:
                    log.warning(
                        "no connection can be accepted: %s; the longest waiting one is closed", failure.strerror
                    )
                exhausted = loop.time()
                self._visitors.make_room()
                await asyncio.sleep(RETRY_S)
                continue
            if exhausted is not None and loop.time() - exhausted >= CALM_AFTER_S:
                log.info("connections are accepted again")
                exhausted = None

    def _protocol(self) -> asyncio.Protocol:
        make: Callable[..., asyncio.Protocol] = self.config.http_protocol_class
        return make(config=self.config, server_state=self.server_state, app_state=self.lifespan.state)

    def _accepting_ended(self, _: asyncio.Task[None]) -> None:
        self.should_exit = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End every connection; those whose peer does not read are cut."""
        for task in self._accepting:
            task.cancel()
        if self._accepting:
            await asyncio.wait(self._accepting)
        if self._handshakes is not None:
            await self._handshakes.end()
        loop = asyncio.get_running_loop()
        cut = loop.call_later(GRACE_S, self._cut)
        try:
            await super().shutdown(sockets)
        finally:
            cut.cancel()

    def _cut(self) -> None:
        for connection in list(self.server_state.connections):
            if connection.transport is not None:
                connection.transport.abort()


async def serve(
    app: ASGIApp,
    host: str,
    port: int,
    *,
    listener: socket.socket | None = None,
    scene: socket.socket | None = None,
    tls: ssl.SSLContext | None = None,
    started: Callable[[str], None] | None = None,
) -> None:
    """Serve ``app`` until cancelled, then end within a second.

    ``listener`` is a socket from :func:`listen`, if one was bound beforehand; ``scene`` one from
    :func:`listen_for_scene`, if the 3D view has a port of its own. ``tls`` encrypts the connections to both; None: they
    are plain. ``started(url)`` is called once requests are answered. Raises ConfigError when the address cannot be had.
    """
    sock = listener or listen(host, port)
    visitors = Visitors(most_connections())
    config = uvicorn.Config(
        app,
        http=partial(BoundedHttp, visitors=visitors),  # type: ignore[arg-type]  # what makes one will do
        ws=partial(BoundedWebSocket, visitors=visitors),  # type: ignore[arg-type]
        timeout_keep_alive=KEEP_ALIVE_S,
        h11_max_incomplete_event_size=LARGEST_HEADER_BYTES,
        ws_per_message_deflate=False,
        ws_max_size=LARGEST_MESSAGE_BYTES,
        ws_ping_interval=10,
        ws_ping_timeout=10,
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=2 * GRACE_S,  # type: ignore[arg-type]  # seconds, any number will do
    )
    server = _Server(config, visitors, tls)
    url = url_of(sock, secure=tls is not None)
    sockets = [sock] if scene is None else [sock, scene]
    task = asyncio.create_task(server.serve(sockets), name="console")
    try:
        while not server.started and not task.done():
            # uvicorn has no event for this.
            await asyncio.wait({task}, timeout=0.01)
        if started is not None and not task.done():
            started(url)
        await asyncio.shield(task)
        if (failure := server.failure()) is not None:
            raise failure
    except asyncio.CancelledError:
        server.should_exit = True
        await task
        raise
    finally:
        for each in sockets:
            each.close()
