"""A page without a browser: one connection to the live stream."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import time
from collections.abc import AsyncIterator, Callable
from typing import Any

import numpy as np
import websockets
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection

from tests.patience import PATIENCE_S

#: Messages that say when they were sent, and by what the robot said last.
TIMED = ("drive", "look", "take_control", "clear_e_stop", "ping")
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
        #: The robot's newest stamp, and when it came by this page's clock (ms).
        self.heard: dict[str, float] = {}
        self._greeted = asyncio.Event()
        self._frames: asyncio.Queue[dict[str, Any] | bytes | Exception] = asyncio.Queue()
        self._reading: asyncio.Task[None] | None = None

    @staticmethod
    def clock() -> float:
        """This page's clock (ms), of an origin of its own."""
        return 1e3 * time.monotonic() + 12_345_678.9

    def begin_reading(self) -> None:
        """Take frames as they come, looked at or not, as a page does."""
        self.connection.transport.resume_reading()
        self._reading = asyncio.create_task(self._read())

    async def stop_reading(self) -> None:
        """Take no more frames, as a page that is frozen."""
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.wait({self._reading})
        self.connection.transport.pause_reading()

    async def _read(self) -> None:
        try:
            while True:
                frame = await self.connection.recv()
                message = frame if isinstance(frame, bytes) else json.loads(frame)
                if isinstance(message, dict) and message["type"] in ("hello", "status", "pong"):
                    self.heard = {"heard": message["stamp"], "heard_t": self.clock()}
                    self._greeted.set()
                self._frames.put_nowait(message)
        except websockets.ConnectionClosed as end:
            self._frames.put_nowait(end)

    async def receive(self) -> dict[str, Any] | bytes:
        """The next frame. Raises websockets.ConnectionClosed at the end."""
        async with asyncio.timeout(PATIENCE_S):
            frame = await self._frames.get()
        if isinstance(frame, Exception):
            self._frames.put_nowait(frame)
            raise frame
        return frame

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
        """Send a message of ``kind``, with its time where it has one."""
        timed = {"t": self.clock(), **self.heard} if kind in TIMED else {}
        await self.connection.send(json.dumps({"type": kind, **timed, **content}))

    async def greeted(self) -> None:
        """Wait until the robot has said what time it is."""
        async with asyncio.timeout(PATIENCE_S):
            await self._greeted.wait()

    async def drive(self, linear: float, angular: float = 0.0, *, held: bool = True) -> None:
        await self.greeted()
        self.sequence += 1
        await self.send("drive", seq=self.sequence, held=held, linear=linear, angular=angular)


@contextlib.asynccontextmanager
async def page(url: str, operator: str = "Ann", **options: Any) -> AsyncIterator[Page]:
    """A page connected to the console at ``url``."""
    address = url.replace("http://", "ws://") + f"/api/v1/live?operator={operator}"
    options = {"max_queue": None, "close_timeout": 1, "open_timeout": PATIENCE_S, **options}
    async with websockets.connect(address, compression=None, proxy=None, max_size=None, **options) as connection:
        found = Page(connection)
        found.begin_reading()
        try:
            yield found
        finally:
            await found.stop_reading()
            connection.transport.resume_reading()
