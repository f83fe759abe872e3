"""A page without a browser: one connection to the live stream."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
from collections.abc import AsyncIterator, Callable
from typing import Any

import numpy as np
import websockets
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection

from tests.patience import PATIENCE_S

#: Of sound and speech: kind, seq, stamp, samples, channels, rate.
SOUND_HEADER = struct.Struct("<B3xIdHHI")


def voice(
    seq: int, *, stamp: float = 0.0, samples: int = 320, rate: int = 16_000, channels: int = 1, level: int = 500
) -> bytes:
    """A frame of an operator's voice."""
    header = SOUND_HEADER.pack(17, seq, stamp, samples, channels, rate)
    return header + np.full(samples, level, "<i2").tobytes()


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

    async def sound(self) -> tuple[int, float, int, NDArray[np.int16]]:
        """The next frame of sound: seq, stamp, rate and samples."""
        while (frame := await self.picture())[0] != 16:
            pass
        _, seq, stamp, count, channels, rate = SOUND_HEADER.unpack_from(frame)
        samples = np.frombuffer(frame, "<i2", offset=SOUND_HEADER.size)
        assert (len(samples), channels) == (count, 1)
        return seq, stamp, rate, samples

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
