"""The connection to rosbridge says why there is none, and opens again; and the questions to rosapi that go by it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from app.robots.ros2.rosbridge import connection
from app.robots.ros2.rosbridge.connection import Connection
from app.robots.ros2.rosbridge.rosapi import Rosapi
from app.runtime.clock import run_virtual
from tests.patience import PATIENCE_S


class Held:
    """A connection to a server that does ``answer``, which is held until it was opened ``times`` over. ``problems`` are
    those that it had when it was opened."""

    def __init__(self, answer: Callable[[ServerConnection], Awaitable[None]], times: int) -> None:
        self._answer = answer
        self._times = times
        self._ended = asyncio.Event()
        self.taken: list[dict[str, Any]] = []
        self.said: list[str] = []
        self.problems: list[str] = []
        self.url = ""
        #: What it answers in place of opening.
        self.status: HTTPStatus | None = None

    async def run(self) -> None:
        """Hold it."""
        async with serve(self._answer, "127.0.0.1", 0, process_request=self._asked, close_timeout=0.1) as server:
            self.url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"
            self.connection = Connection(
                self.url, 1 << 20, opened=self._open, take=self.taken.append, say=self.said.append
            )
            holding = asyncio.create_task(self.connection.run())
            async with asyncio.timeout(PATIENCE_S):
                await self._ended.wait()
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)

    def _asked(self, websocket: ServerConnection, _: Request) -> Response | None:
        self.problems.append(self.connection.problem)
        if self.status is None:
            return None
        if len(self.problems) == self._times:
            self._ended.set()
        return websocket.respond(self.status, "")

    def _open(self) -> None:
        for number in range(3):
            self.connection.send({"op": "publish", "topic": "/cmd_vel", "msg": number}, "/cmd_vel")
        self.connection.send({"op": "advertise"})
        if len(self.problems) == self._times:
            self._ended.set()


async def test_it_opens_again_and_sends_the_newest_alone() -> None:
    heard: list[list[dict[str, Any]]] = []

    async def answer(websocket: ServerConnection) -> None:
        heard.append([json.loads(await websocket.recv()), json.loads(await websocket.recv())])
        await websocket.send("nonsense")
        await websocket.send('{"op": "publish"}')

    held = Held(answer, 2)
    await held.run()
    gone = f"rosbridge at {held.url} does not answer"
    assert held.problems == [gone, f"{gone}: it closed the connection"]
    assert heard[0] == [{"op": "publish", "topic": "/cmd_vel", "msg": 2}, {"op": "advertise"}]
    assert held.taken[0] == {"op": "publish"}
    assert held.said[0].startswith(f"rosbridge at {held.url} sent what cannot be read: it is no JSON")


async def test_a_message_that_is_too_large_is_not_taken() -> None:
    async def answer(websocket: ServerConnection) -> None:
        await websocket.send(json.dumps({"data": "x" * (1 << 20)}))
        await websocket.wait_closed()

    held = Held(answer, 2)
    await held.run()
    assert held.problems[1].endswith("it sent a message of more than 1 MiB")
    assert held.taken == []


async def test_a_frozen_server_is_given_up_and_another_connection_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "LOST_S", 0.2)

    async def freeze(websocket: ServerConnection) -> None:
        websocket.transport.pause_reading()
        await websocket.wait_closed()

    held = Held(freeze, 2)
    await held.run()
    assert held.problems[1] == f"rosbridge at {held.url} does not answer"


async def test_what_is_no_websocket_is_said() -> None:
    async def refuse(websocket: ServerConnection) -> None:
        raise AssertionError  # it is not reached

    held = Held(refuse, 2)
    held.status = HTTPStatus.NOT_FOUND
    await held.run()
    assert held.problems[1] == (
        f"rosbridge at {held.url} does not answer: it is no WebSocket of rosbridge (server rejected WebSocket "
        "connection: HTTP 404)"
    )


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ({"subscribers": ["/base", "/rosbridge_websocket", "/ns/rosbridge"]}, ["/base"]),
        ({"subscribers": []}, []),
        ({"subscribers": "all"}, None),
        ({"subscribers": [1]}, None),
        ("there is no such service", None),
        (None, None),
    ],
)
def test_who_listens(values: object, found: list[str] | None) -> None:
    asked: list[dict[str, Any]] = []

    def send(message: dict[str, Any]) -> None:
        asked.append(message)
        rosapi.take({"op": "service_response", "id": "of another", "values": {"subscribers": ["/x"]}, "result": True})
        rosapi.take({"op": "service_response", "id": message["id"], "values": values, "result": True})

    rosapi = Rosapi(send)
    assert run_virtual(rosapi.subscribers("/cmd_vel")) == found
    assert asked == [
        {"op": "call_service", "id": "hbba 0", "service": "/rosapi/subscribers", "args": {"topic": "/cmd_vel"}}
    ]


def test_rosapi_that_does_not_answer_or_refuses() -> None:
    assert run_virtual(Rosapi(lambda _: None).types()) is None

    def refuse(message: dict[str, Any]) -> None:
        refusing.take({"id": message["id"], "values": {"topics": [], "types": []}, "result": False})

    refusing = Rosapi(refuse)
    assert run_virtual(refusing.types()) is None
