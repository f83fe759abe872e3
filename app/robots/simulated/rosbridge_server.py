"""rosbridge's side of its protocol (v2.0) for a simulated robot: topics in JSON, and the services of rosapi that say
who is there. As rosbridge does, it drops a subscription without a type to a topic that is not there.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from app.robots.ros2.rosbridge.values import plain_name

#: Nodes of the graph that is played, as rosapi names them.
ROBOT, BRIDGE = "/robot", "/rosbridge_websocket"


@dataclass(slots=True)
class _Wanted:
    """A subscription: the least time (s) between messages, whether the newest is enough, and when the last went."""

    throttle_s: float
    newest: bool
    sent: float = 0.0


class _Client:
    """One connection, and what it is to be sent."""

    def __init__(self, websocket: ServerConnection) -> None:
        self._websocket = websocket
        self.wanted: dict[str, _Wanted] = {}
        self.advertised: set[str] = set()
        self._unsent: dict[object, str] = {}
        self._has_unsent = asyncio.Event()

    def send(self, text: str, key: object = None) -> None:
        """Send ``text``, in place of what waits under ``key``."""
        self._unsent[key if key is not None else object()] = text
        self._has_unsent.set()

    def publish(self, topic: str, text: str) -> None:
        """Send a message of ``topic``, where it is wanted, and not too soon."""
        wanted, now = self.wanted.get(topic), time.monotonic()
        if wanted is not None and now - wanted.sent >= wanted.throttle_s:
            wanted.sent = now
            self.send(text, topic if wanted.newest else None)

    async def write(self) -> None:
        """Send, until the connection closes."""
        with contextlib.suppress(ConnectionClosed):
            while True:
                await self._has_unsent.wait()
                while self._unsent:
                    await self._websocket.send(self._unsent.pop(next(iter(self._unsent))))
                self._has_unsent.clear()


class RosbridgeServer:
    """The graph of a robot that publishes ``published`` (types by topic, as ROS 2 names them), and listens to
    ``taken``: by topic its type, and what gets each message's ``msg``, which raises KeyError, TypeError or ValueError
    for one that is not of it. ``ros1``: types have the names that they have in ROS 1; ``has_rosapi``: rosapi runs."""

    def __init__(
        self,
        published: Mapping[str, str],
        taken: Mapping[str, tuple[str, Callable[[dict[str, Any]], None]]],
        *,
        ros1: bool = False,
        has_rosapi: bool = True,
    ) -> None:
        self._types = {topic: self._named(kind, ros1) for topic, kind in published.items()}
        self._taken = {topic: take for topic, (_, take) in taken.items()}
        self._types |= {topic: self._named(kind, ros1) for topic, (kind, _) in taken.items()}
        self._published = set(published)
        self._clients: set[_Client] = set()
        self._server: Server | None = None
        self._has_rosapi = has_rosapi

    async def open(self, port: int) -> int:
        """Listen on ``port`` of this computer, 0 for a free one; returns it."""
        self._server = await serve(self._serve, "127.0.0.1", port, compression=None, max_size=1 << 20)
        found: int = next(iter(self._server.sockets)).getsockname()[1]
        return found

    async def close(self) -> None:
        """Close every connection, and listen no more."""
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    def publish(self, topic: str, message: dict[str, Any]) -> None:
        """Give ``message`` to all who want it."""
        if any(topic in client.wanted for client in self._clients):
            self.say(json.dumps({"op": "publish", "topic": topic, "msg": message}), topic)

    def say(self, text: str, topic: str | None = None) -> None:
        """Send ``text`` to all who want ``topic``; without one, to every client."""
        for client in self._clients:
            if topic is None:
                client.send(text)
            else:
                client.publish(topic, text)

    async def _serve(self, websocket: ServerConnection) -> None:
        client = _Client(websocket)
        self._clients.add(client)
        writer = asyncio.create_task(client.write())
        try:
            async for frame in websocket:
                self._take(client, json.loads(frame))
        finally:
            self._clients.discard(client)
            writer.cancel()

    def _take(self, client: _Client, message: dict[str, Any]) -> None:
        try:
            answer = self._answer(client, message)
        except (KeyError, TypeError, ValueError) as failure:
            said = f"{message.get('op')}: {failure}"
            answer = {"op": "status", "level": "error", "msg": said, "id": message.get("id")}
        if answer is not None:
            client.send(json.dumps(answer))

    def _answer(self, client: _Client, message: dict[str, Any]) -> dict[str, Any] | None:
        match message:
            case {"op": "subscribe", "topic": topic}:
                self._check(topic, message.get("type"))
                client.wanted[topic] = _Wanted(
                    message.get("throttle_rate", 0) / 1000.0, message.get("queue_length", 0) == 1
                )
            case {"op": "unsubscribe", "topic": topic}:
                client.wanted.pop(topic, None)
            case {"op": "advertise", "topic": topic, "type": kind}:
                self._check(topic, kind)
                client.advertised.add(topic)
            case {"op": "unadvertise", "topic": topic}:
                client.advertised.discard(topic)
            case {"op": "publish", "topic": topic, "msg": given}:
                if topic not in client.advertised:
                    raise ValueError(f"{topic} is not advertised")
                self._taken[topic](given)
            case {"op": "call_service", "service": service}:
                values = self._said(service, message.get("args", {}))
                result = {"values": values or f"there is no service {service}", "result": values is not None}
                return {"op": "service_response", "service": service, "id": message.get("id")} | result
            case _:
                raise ValueError("there is no such operation")
        return None

    def _check(self, topic: str, kind: str | None) -> None:
        """Raise ValueError for a topic that is not there, or that has another type."""
        if kind is None and topic not in self._types:
            raise ValueError(f"{topic} is not established, and no type is given")
        if kind is not None and kind != self._types.get(topic, kind):
            raise ValueError(f"{topic} has the type {self._types[topic]}, not {kind}")

    def _said(self, service: str, arguments: dict[str, Any]) -> dict[str, Any] | None:
        if not self._has_rosapi:
            return None
        match service.removeprefix("/rosapi/"), arguments:
            case "topics", _:
                return {"topics": list(self._types), "types": list(self._types.values())}
            case "subscribers", {"topic": topic}:
                bridge = [BRIDGE] * any(topic in client.wanted for client in self._clients)
                return {"subscribers": [ROBOT] * (topic in self._taken) + bridge}
            case "publishers", {"topic": topic}:
                bridge = [BRIDGE] * any(topic in client.advertised for client in self._clients)
                return {"publishers": [ROBOT] * (topic in self._published) + bridge}
            case _:
                return None

    @staticmethod
    def _named(kind: str, ros1: bool) -> str:
        return plain_name(kind) if ros1 else kind
