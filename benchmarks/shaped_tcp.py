"""A TCP connection passed on in between, at a rate that may be changed or at none: a bad link, without privileges."""

from __future__ import annotations

import asyncio
import socket
import threading
from types import TracebackType

_CHUNK = 8 * 1024
_BUFFER = 32 * 1024


class ShapedTcp:
    """Listens on a free :attr:`port` of this computer and passes on to ``to``; in a thread of its own, with small
    buffers. ``bytes_per_s``: each way, None for as fast as it goes; ``held``: nothing passes."""

    def __init__(self, to: int) -> None:
        self.bytes_per_s: float | None = None
        self.held = False
        self.passed = 0
        self._to = to
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self.port = int(self._listener.getsockname()[1])
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="shaped tcp")

    def __enter__(self) -> ShapedTcp:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._listener.close()

    def _run(self) -> None:
        server = self._loop.run_until_complete(
            asyncio.start_server(self._connected, sock=self._listener, limit=_BUFFER)
        )
        self._loop.run_forever()
        server.close()
        for task in asyncio.all_tasks(self._loop):
            task.cancel()
        self._loop.run_until_complete(asyncio.sleep(0))
        self._loop.close()

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        beyond = socket.socket()
        beyond.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        beyond.setblocking(False)
        try:
            await self._loop.sock_connect(beyond, ("127.0.0.1", self._to))
        except OSError:
            writer.close()
            return
        far_reader, far_writer = await asyncio.open_connection(sock=beyond, limit=_BUFFER)
        ways = [self._pass(reader, far_writer), self._pass(far_reader, writer)]
        await asyncio.wait([asyncio.ensure_future(way) for way in ways], return_when=asyncio.FIRST_COMPLETED)
        for each in (writer, far_writer):
            each.close()

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while chunk := await reader.read(_CHUNK):
                while self.held:  # noqa: ASYNC110  # set by another thread
                    await asyncio.sleep(0.01)
                if self.bytes_per_s is not None:
                    await asyncio.sleep(len(chunk) / self.bytes_per_s)
                self.passed += len(chunk)
                writer.write(chunk)
                await writer.drain()
        except OSError:
            return
