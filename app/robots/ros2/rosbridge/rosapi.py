"""What the robot's graph has, as the services of rosapi say it; rosbridge's launch files start rosapi beside it."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable
from typing import Any

ASK_S = 2.0
"""How long an answer may take. A graph of ROS 1 is asked node by node."""
#: So many names are taken of an answer.
_NAMES = 10_000


class Rosapi:
    """Asks by ``send``, which sends a message of rosbridge's protocol."""

    def __init__(self, send: Callable[[dict[str, Any]], None]) -> None:
        self._send = send
        self._numbers = itertools.count()
        self._asked: dict[str, asyncio.Future[Any]] = {}

    def take(self, message: dict[str, Any]) -> None:
        """Take a ``service_response``."""
        asked = self._asked.get(str(message.get("id")))
        if asked is not None and not asked.done():
            values = message.get("values")
            asked.set_result(values if message.get("result") is not False and isinstance(values, dict) else None)

    async def types(self) -> dict[str, str] | None:
        """The topics' types by name; None without an answer."""
        values = await self._call("topics", {})
        names, types = _strings(values, "topics"), _strings(values, "types")
        return None if names is None or types is None else dict(zip(names, types, strict=False))

    async def subscribers(self, topic: str) -> list[str] | None:
        """The nodes that listen to ``topic``, but for rosbridge itself; None without an answer."""
        return _others(_strings(await self._call("subscribers", {"topic": topic}), "subscribers"))

    async def publishers(self, topic: str) -> list[str] | None:
        """The nodes that publish on ``topic``, but for rosbridge itself; None without an answer."""
        return _others(_strings(await self._call("publishers", {"topic": topic}), "publishers"))

    async def _call(self, service: str, arguments: dict[str, str]) -> dict[str, Any] | None:
        number = f"hbba {next(self._numbers)}"
        asked = self._asked[number] = asyncio.get_running_loop().create_future()
        self._send({"op": "call_service", "id": number, "service": f"/rosapi/{service}", "args": arguments})
        try:
            async with asyncio.timeout(ASK_S):
                values: dict[str, Any] | None = await asked
                return values
        except TimeoutError:
            return None
        finally:
            del self._asked[number]


def _strings(values: dict[str, Any] | None, key: str) -> list[str] | None:
    found = None if values is None else values.get(key)
    if not isinstance(found, list) or not all(isinstance(each, str) for each in found):
        return None
    return found[:_NAMES]


def _others(nodes: list[str] | None) -> list[str] | None:
    return None if nodes is None else [node for node in nodes if not node.rpartition("/")[2].startswith("rosbridge")]
