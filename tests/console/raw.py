"""HTTP as no client of good manners sends it: bytes over a real socket."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from urllib.parse import urlsplit


class Raw:
    """One connection."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader = reader
        self._writer = writer

    async def send(self, data: bytes) -> None:
        """Send ``data``, as far as the other end takes it."""
        with contextlib.suppress(ConnectionError):
            self._writer.write(data)
            await self._writer.drain()

    async def answer(self) -> tuple[int, bytes]:
        """Status and everything else up to the end of the connection."""
        said = await self.rest()
        return int(said.split()[1]), said

    async def rest(self) -> bytes:
        """Everything up to the end of the connection, however it ends."""
        said = b""
        with contextlib.suppress(ConnectionError):
            while part := await self.reader.read(65_536):
                said += part
        return said

    def close(self) -> None:
        """End it."""
        self._writer.close()


@contextlib.asynccontextmanager
async def connected(url: str) -> AsyncIterator[Raw]:
    """A connection to the console at ``url``."""
    parts = urlsplit(url)
    raw = Raw(*await asyncio.open_connection(parts.hostname, parts.port))
    try:
        yield raw
    finally:
        raw.close()


def request(line: str, *fields: str, body: bytes = b"") -> bytes:
    """A request with a Host."""
    return "\r\n".join([f"{line} HTTP/1.1", "Host: localhost", *fields, "", ""]).encode() + body
