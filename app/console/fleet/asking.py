"""Asks the consoles of other robots, when somebody looks at the fleet.

Imported with a fleet alone: httpx takes a tenth of a second, which other robots do not spend.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import httpx

from app.console.fleet.fleet_file import RobotConsole
from app.console.fleet.robots import robot_of, unreachable
from app.console.records.fleet import FleetRobot

#: A console answers within this (s), or is not reached.
ANSWERS_WITHIN_S: Final = 2.0
_MOST_BYTES: Final = 1 << 20


class Fleet:
    """Asks the consoles of other robots, all at once; who asks meanwhile gets the same answer."""

    def __init__(self, consoles: Sequence[RobotConsole]) -> None:
        self._consoles = consoles
        self._clients: dict[RobotConsole, httpx.AsyncClient] = {}
        self._asking: asyncio.Task[tuple[FleetRobot, ...]] | None = None

    async def robots(self) -> tuple[FleetRobot, ...]:
        """The robots, in the order of the file; within ANSWERS_WITHIN_S."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(self._ask_all(), name="fleet")
        return await asyncio.shield(self._asking)

    async def close(self) -> None:
        """Ask nothing more."""
        if self._asking is not None:
            self._asking.cancel()
            await asyncio.gather(self._asking, return_exceptions=True)
        await asyncio.gather(*(client.aclose() for client in self._clients.values()))

    async def _ask_all(self) -> tuple[FleetRobot, ...]:
        return tuple(await asyncio.gather(*(self._ask(console) for console in self._consoles)))

    async def _ask(self, console: RobotConsole) -> FleetRobot:
        try:
            async with asyncio.timeout(ANSWERS_WITHIN_S):
                status, answer = await _get(self._client(console), "/api/v1/robot")
        except TimeoutError:
            return unreachable(console.url, f"It did not answer within {ANSWERS_WITHIN_S:g} s.")
        except (httpx.HTTPError, httpx.InvalidURL, OSError) as failure:
            return unreachable(console.url, f"It cannot be reached: {str(failure) or type(failure).__name__}.")
        if status in (401, 403):
            detail = "Its console asks for a login: name its token's file in the fleet's file."
            if console.token is not None:
                detail = "Its console refuses the login of the fleet's file."
            return replace(unreachable(console.url, detail), state="refused")
        if status != 200:
            return unreachable(console.url, f"It answers with HTTP status {status}.")
        return robot_of(answer, console.url)

    def _client(self, console: RobotConsole) -> httpx.AsyncClient:
        if console not in self._clients:
            headers = {} if console.token is None else {"authorization": f"Bearer {console.token}"}
            # Without TLS there is nothing to verify. A token is not sent on to where a console might point.
            self._clients[console] = httpx.AsyncClient(
                base_url=console.url,
                headers=headers,
                verify=console.tls or False,
                timeout=None,
                follow_redirects=False,
                trust_env=False,
            )
        return self._clients[console]


async def _get(client: httpx.AsyncClient, path: str) -> tuple[int, bytes]:
    """Status and body of what is at ``path``; a body beyond _MOST_BYTES is cut off."""
    body = bytearray()
    async with client.stream("GET", path) as response:
        async for part in response.aiter_bytes(1 << 16):
            body += part[: _MOST_BYTES - len(body)]
            if len(body) >= _MOST_BYTES:
                break
        return response.status_code, bytes(body)
