"""A network that delays: a TCP proxy before the console."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from urllib.parse import urlsplit


class SlowLink:
    """Passes bytes on ``up_s`` (to the robot) and ``down_s`` (from it) after they came; both may change at any time,
    and order is kept. Everything ends with it."""

    def __init__(self, url: str) -> None:
        self.up_s = 0.0
        self.down_s = 0.0
        self.url = ""
        self._host, self._port = urlsplit(url).hostname, urlsplit(url).port
        self._tasks: set[asyncio.Task[None]] = set()

    def accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """A connection begins."""
        self._start(self._connect(reader, writer))

    async def close(self) -> None:
        """End every connection."""
        while self._tasks:
            for task in self._tasks:
                task.cancel()
            await asyncio.wait(self._tasks)
            self._tasks = {task for task in self._tasks if not task.done()}

    def _start(self, coroutine) -> asyncio.Task[None]:  # type: ignore[no-untyped-def]
        task: asyncio.Task[None] = asyncio.create_task(coroutine)
        self._tasks.add(task)
        return task

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.closing(writer):
            there_reader, there_writer = await asyncio.open_connection(self._host, self._port)
            with contextlib.closing(there_writer):
                up = self._start(self._pass_on(reader, there_writer, lambda: self.up_s))
                down = self._start(self._pass_on(there_reader, writer, lambda: self.down_s))
                await asyncio.wait({up, down}, return_when=asyncio.FIRST_COMPLETED)

    async def _pass_on(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, delay_s: Callable[[], float]
    ) -> None:
        loop = asyncio.get_running_loop()
        under_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        delivering = self._start(self._deliver(under_way, writer))
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(65536):
                under_way.put_nowait((loop.time() + delay_s(), data))
        under_way.put_nowait((0.0, b""))
        await delivering

    async def _deliver(self, under_way: asyncio.Queue[tuple[float, bytes]], writer: asyncio.StreamWriter) -> None:
        loop = asyncio.get_running_loop()
        with contextlib.suppress(ConnectionError):
            while (arriving := await under_way.get())[1]:
                await asyncio.sleep(arriving[0] - loop.time())
                writer.write(arriving[1])
                await writer.drain()


@contextlib.asynccontextmanager
async def slow_link(url: str) -> AsyncIterator[SlowLink]:
    """A slow way to the console at ``url``; no slower than any other until its delays are set."""
    link = SlowLink(url)
    server = await asyncio.start_server(link.accept, "127.0.0.1", 0)
    link.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    try:
        yield link
    finally:
        server.close()
        await link.close()


@contextlib.contextmanager
def slow_link_aside(url: str) -> Iterator[SlowLink]:
    """The same on an event loop in a thread of its own, for tests without one."""
    ready: list[SlowLink] = []
    loop = asyncio.new_event_loop()
    up, end = threading.Event(), asyncio.Event()

    async def run() -> None:
        async with slow_link(url) as link:
            ready.append(link)
            up.set()
            await end.wait()

    def serve() -> None:
        try:
            loop.run_until_complete(run())
        finally:
            up.set()
            loop.close()

    thread = threading.Thread(target=serve, name="slow link")
    thread.start()
    up.wait()
    try:
        yield ready[0]
    finally:
        loop.call_soon_threadsafe(end.set)
        thread.join()
