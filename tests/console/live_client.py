"""A page without a browser: one connection to the live stream."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Callable
from typing import Any

import websockets
from websockets.asyncio.client import ClientConnection

PATIENCE_S = 5.0


class Page:
    """Reads frames as they come; sends what a page sends."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.sequence = 0

    async def receive(self) -> dict[str, Any] | bytes:
        """The next frame."""
        async with asyncio.timeout(PATIENCE_S):
            frame = await self.connection.recv()
        return frame if isinstance(frame, bytes) else json.loads(frame)

    async def until(
        self, kind: str, holds: Callable[[dict[str, Any]], bool] = lambda _: True, within_s: float = PATIENCE_S
    ) -> dict[str, Any]:
        """The next message of ``kind`` of which ``holds`` is true."""
        async with asyncio.timeout(within_s):
            while True:
                frame = await self.receive()
                if isinstance(frame, dict) and frame["type"] == kind and holds(frame):
                    return frame

    async def picture(self) -> bytes:
        """The next binary frame."""
        async with asyncio.timeout(PATIENCE_S):
            while True:
                frame = await self.receive()
                if isinstance(frame, bytes):
                    return frame

    async def send(self, kind: str, /, **content: Any) -> None:
        await self.connection.send(json.dumps({"type": kind, **content}))

    async def drive(self, linear: float, angular: float = 0.0, *, held: bool = True) -> None:
        self.sequence += 1
        await self.send("drive", seq=self.sequence, held=held, linear=linear, angular=angular)


@contextlib.asynccontextmanager
async def page(url: str, operator: str = "Ann", **options: Any) -> AsyncIterator[Page]:
    """A page connected to the console at ``url``."""
    address = url.replace("http://", "ws://") + f"/api/v1/live?operator={operator}"
    options = {"max_queue": None, "close_timeout": 1, **options}
    async with websockets.connect(address, compression=None, proxy=None, max_size=None, **options) as connection:
        yield Page(connection)
