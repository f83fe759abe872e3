"""Every stream between the program and its pages through one bad link, for tests and for people: as ASGI.

The live stream both ways, the 3D view's relay and its pulse, REST and the page's files all pass here, outermost.
A stream holds back its sender once as much waits to leave as a socket of the program's would hold. Not shaped: the
handshake of a connection, which has taken place before a request comes here.
"""

from __future__ import annotations

import asyncio
import random
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.base.network_link import Direction, LinkSettings, Stream
from app.base.observers import Observers
from app.console.records.link import LinkReport

#: So much may wait to leave before the sender waits, too: what a socket of the console's holds.
UNSENT_BYTES = 64 * 1024
#: A message leaves in parts, so that other streams have their turns.
PART_BYTES = 16 * 1024
#: So much of one stream may be on its way: a window of TCP.
WINDOW_BYTES = 4 * 1024 * 1024


class Link:
    """The link between the program and all its pages; ``settings`` may change at any time."""

    def __init__(self, settings: LinkSettings | None = None, *, seed: int | None = None) -> None:
        self._settings = settings or LinkSettings()
        draw = random.Random(seed)
        self.up, self.down = Direction(draw), Direction(draw)
        self._observers: Observers[[LinkSettings]] = Observers("the link")

    @property
    def settings(self) -> LinkSettings:
        """How it is shaped now."""
        return self._settings

    def change(self, settings: LinkSettings) -> None:
        """Shape by ``settings`` what is sent from now on."""
        self._settings = settings
        self._observers.notify(settings)

    def observe(self, observer: Callable[[LinkSettings], object]) -> Callable[[], None]:
        """Call ``observer`` at each change, until the function returned is called."""
        return self._observers.add(observer)

    def report(self) -> LinkReport:
        """The settings in the units of people."""
        settings = self._settings
        return LinkReport(
            shaped=settings.shapes,
            delay_ms=round(1e3 * settings.delay_s, 3),
            jitter_ms=round(1e3 * settings.jitter_s, 3),
            loss_percent=round(1e2 * settings.loss, 3),
            rate_mbit=None if settings.rate_bps is None else round(1e-6 * settings.rate_bps, 6),
            text=settings.words,
        )


class Shaped:
    """ASGI: ``app`` behind ``link``. While that shapes nothing, messages pass as they are."""

    def __init__(self, app: ASGIApp, link: Link) -> None:
        self._app = app
        self._link = link

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        up, down = _Up(self._link, receive), _Down(self._link, send)
        try:
            try:
                await self._app(scope, up.receive, down.send)
            except Exception:
                await down.drain()  # the answer that says so
                raise
            await down.drain()
        finally:
            await asyncio.gather(up.close(), down.close())


class _Pipe:
    """One stream in one direction: messages go to ``deliver`` when they arrive, in order.

    Its first failure ends it, and is raised by the next :meth:`put`.
    """

    def __init__(self, link: Link, direction: Direction, deliver: Callable[[Message], Awaitable[None]]) -> None:
        self._link = link
        self._direction = direction
        self._deliver = deliver
        self._stream = Stream()
        #: When each arrives, and its size.
        self._under_way: deque[tuple[float, int, Message]] = deque()
        self._bytes = 0
        self._news = asyncio.Event()
        self._room = asyncio.Event()
        self._delivering: asyncio.Task[None] | None = None
        self.failure: Exception | None = None

    @property
    def busy(self) -> bool:
        """Whether anything is on its way."""
        return self._bytes > 0

    async def put(self, message: Message) -> None:
        """Send ``message``; returns when there is room for the next."""
        if self._delivering is None:
            self._delivering = asyncio.create_task(self._run(), name="link")
        loop, size = asyncio.get_running_loop(), _size(message)
        left, arrives = size, 0.0
        while True:
            part = min(left, PART_BYTES)
            settings = self._link.settings
            passage = self._direction.send(settings, self._stream, loop.time(), part)
            arrives, left = passage.arrives, left - part
            if left <= 0:
                break
            await self._wait_for_departure(settings)
        self._under_way.append((arrives, size + 1, message))
        self._bytes += size + 1
        self._news.set()
        await self._wait_for_departure(settings)
        while self._bytes > WINDOW_BYTES and self.failure is None:
            self._room.clear()
            await self._room.wait()
        if self.failure is not None:
            raise self.failure

    async def _wait_for_departure(self, settings: LinkSettings) -> None:
        """Wait until what has not left yet would fit the socket."""
        if settings.rate_bps is not None:
            now = asyncio.get_running_loop().time()
            wait_s = self._direction.free_at(now) - now - 8.0 * UNSENT_BYTES / settings.rate_bps
            if wait_s > 0:
                await asyncio.sleep(wait_s)

    async def drain(self) -> None:
        """Wait until all has arrived, or cannot any more."""
        while self.busy and self.failure is None:
            self._room.clear()
            await self._room.wait()

    async def close(self) -> None:
        """Drop what is on its way."""
        if self._delivering is not None:
            self._delivering.cancel()
            await asyncio.wait({self._delivering})

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        while self.failure is None:
            while not self._under_way:
                self._news.clear()
                await self._news.wait()
            arrives, size, message = self._under_way.popleft()
            if (wait_s := arrives - loop.time()) > 0:
                await asyncio.sleep(wait_s)
            try:
                await self._deliver(message)
            except Exception as failure:  # noqa: BLE001  # raised where the next is sent
                self.failure = failure
            self._bytes -= size
            self._room.set()


class _Down:
    """What the program sends to a page."""

    def __init__(self, link: Link, send: Send) -> None:
        self._link = link
        self._send = send
        self._pipe = _Pipe(link, link.down, send)

    async def send(self, message: Message) -> None:
        """Send by the link; at once while it shapes nothing."""
        if self._pipe.failure is not None:
            raise self._pipe.failure
        if self._link.settings.shapes or self._pipe.busy:
            await self._pipe.put(message)
        else:
            await self._send(message)

    async def drain(self) -> None:
        """Wait until all has arrived. Raises what kept it from that, but for the page's having left."""
        await self._pipe.drain()
        if self._pipe.failure is not None and not isinstance(self._pipe.failure, OSError):
            raise self._pipe.failure

    async def close(self) -> None:
        await self._pipe.close()


class _Up:
    """What a page sends to the program."""

    def __init__(self, link: Link, receive: Receive) -> None:
        self._link = link
        self._receive = receive
        self._arrived: asyncio.Queue[Message] = asyncio.Queue(maxsize=1)
        self._pipe = _Pipe(link, link.up, self._arrived.put)
        self._reading: asyncio.Task[None] | None = None

    async def receive(self) -> Message:
        """The next message, when it has arrived; once the link has shaped a stream, a task reads ahead for it."""
        if self._reading is None:
            if not self._link.settings.shapes:
                return await self._receive()
            self._reading = asyncio.create_task(self._read(), name="link")
        if self._arrived.empty() and self._reading.done() and not self._pipe.busy:
            # The connection has ended, and its end was taken.
            return await self._receive()
        return await self._arrived.get()

    async def _read(self) -> None:
        while True:
            message = await self._receive()
            await self._pipe.put(message)
            if message["type"] in ("websocket.disconnect", "http.disconnect"):
                return

    async def close(self) -> None:
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.wait({self._reading})
        await self._pipe.close()


def _size(message: Message) -> int:
    """About what a message takes on the wire, in bytes, its packets' headers apart."""
    content: Any = message.get("bytes") or message.get("body") or b""
    size = len(content) + len((message.get("text") or "").encode())
    return size + sum(len(name) + len(value) + 4 for name, value in message.get("headers", ()))
