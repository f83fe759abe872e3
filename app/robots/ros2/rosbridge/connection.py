"""One WebSocket to rosbridge, which is opened again whenever it is lost."""

from __future__ import annotations

import asyncio
import json
import math
import socket
import ssl
import time
from collections.abc import Callable
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, WebSocketException

from app.logs.importers.ros_messages import Unreadable
from app.robots.ros2.rosbridge.values import parsed

PING_S = 0.2
"""How often the server is asked for an answer, which the WebSocket itself gives: also while no topic gives anything."""
LOST_S = 3.0
"""After so long without an answer the connection is given up, and opened again."""
_OPEN_S, _CLOSE_S = 3.0, 0.2
_RETRY_S = 0.5
#: Frames that wait to be read; then the server has to wait.
_QUEUE = 4


class Connection:
    """A connection to ``url`` for messages of at most ``most_bytes``. ``opened()`` is called each time it opens, and
    may :meth:`send`; ``take`` gets each message; ``say`` gets sentences on frames that cannot be read."""

    def __init__(
        self,
        url: str,
        most_bytes: int,
        *,
        opened: Callable[[], None],
        take: Callable[[dict[str, Any]], None],
        say: Callable[[str], None],
    ) -> None:
        self._url = url
        self._most_bytes = most_bytes
        self._opened = opened
        self._take = take
        self._say = say
        #: Messages to be sent, the newest of each key.
        self._unsent: dict[object, dict[str, Any]] = {}
        self._has_unsent, self._all_sent = asyncio.Event(), asyncio.Event()
        self._websocket: ClientConnection | None = None
        #: Why there is no connection, in words; "" while there is one.
        self.problem = f"rosbridge at {url} does not answer"
        #: When (monotonic, s) it was last heard, and when it last answered a question.
        self.heard = self.answered = -math.inf

    def send(self, message: dict[str, Any], key: object = None) -> None:
        """Send ``message``; in place of one of the same ``key`` that waits. Without a connection it is lost."""
        if self._websocket is not None:
            self._unsent[key if key is not None else object()] = message
            self._all_sent.clear()
            self._has_unsent.set()

    async def run(self) -> None:
        """Hold the connection, until this is cancelled."""
        while True:
            try:
                async with connect(
                    self._url, proxy=None, compression=None, max_size=self._most_bytes, max_queue=_QUEUE,
                    open_timeout=_OPEN_S, close_timeout=_CLOSE_S, ping_interval=None,
                ) as websocket:  # fmt: skip
                    await self._serve(websocket)
            except (OSError, WebSocketException) as failure:
                why = self._reason(failure)
                self.problem = f"rosbridge at {self._url} does not answer{why and ': '}{why}"
            await asyncio.sleep(_RETRY_S)

    async def flush(self, within_s: float) -> None:
        """Wait until what was sent has arrived, for ``within_s`` at most."""
        if (websocket := self._websocket) is None:
            return
        try:
            async with asyncio.timeout(within_s):
                await self._all_sent.wait()
                await (await websocket.ping())
        except (OSError, WebSocketException):  # it was lost
            return

    async def _serve(self, websocket: ClientConnection) -> None:
        self._unsent.clear()
        self.heard = self.answered = time.monotonic()
        self._websocket, self.problem = websocket, ""
        self._opened()
        tasks = [asyncio.create_task(each(websocket)) for each in (self._read, self._write, self._ask)]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            self._websocket = None
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _read(self, websocket: ClientConnection) -> None:
        while True:
            frame = await websocket.recv()
            self.heard = time.monotonic()
            try:
                self._take(parsed(frame))
            except Unreadable as failure:
                self._say(f"rosbridge at {self._url} sent what cannot be read: {failure}")

    async def _write(self, websocket: ClientConnection) -> None:
        while True:
            await self._has_unsent.wait()
            while self._unsent:
                await websocket.send(json.dumps(self._unsent.pop(next(iter(self._unsent)))))
            self._has_unsent.clear()
            self._all_sent.set()

    async def _ask(self, websocket: ClientConnection) -> None:
        while True:
            async with asyncio.timeout(LOST_S):
                await (await websocket.ping())
            self.heard = self.answered = time.monotonic()
            await asyncio.sleep(PING_S)

    def _reason(self, failure: Exception) -> str:
        """What is known of a failure beyond that nothing answers."""
        match failure:
            case TimeoutError():
                return ""
            case ConnectionRefusedError():
                return "nothing listens there"
            case socket.gaierror():
                return "no computer of that name is known"
            case ssl.SSLCertVerificationError():
                return f"its certificate is not trusted ({failure.verify_message})"
            case ConnectionClosed() if failure.sent is not None and failure.sent.code == 1009:
                return f"it sent a message of more than {self._most_bytes >> 20} MiB"
            case ConnectionClosed():
                return "it closed the connection"
            case InvalidHandshake():
                return f"it is no WebSocket of rosbridge ({failure})"
            case _:
                return str(failure)
