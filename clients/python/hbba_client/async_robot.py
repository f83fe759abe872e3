"""The robot for asynchronous programs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any, Self

import httpx
import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidHandshake, InvalidStatus

from .held import LONGEST_WAIT_S, RENEWALS, new_desire, renewal
from .live import NO_PICTURES, message_of
from .operations import AsyncOperations
from .records import Desire, DesireReport
from .request import BASE, Problem, Request, Unreachable, address_of, headers_of, live_url, problem_of, with_cookies


class AsyncHeldDesire:
    """A desire that is renewed until its block ends."""

    def __init__(self, robot: AsyncRobot, desire: Desire) -> None:
        self.robot = robot
        self.desire = desire

    @property
    def id(self) -> str:
        """The desire's id."""
        return self.desire.id

    async def wait(self, timeout_s: float = LONGEST_WAIT_S) -> DesireReport:
        """Wait for its outcome, ``timeout_s`` at the most; ``outcome`` of the report is null where none came."""
        loop = asyncio.get_running_loop()
        until = loop.time() + timeout_s
        while True:
            left = max(0.0, until - loop.time())
            report = await self.robot.get_desire(self.id, wait=min(left, LONGEST_WAIT_S))
            if report.outcome is not None or left <= LONGEST_WAIT_S:
                return report


class AsyncRobot(AsyncOperations):
    """As ``Robot``, with methods to be awaited."""

    def __init__(
        self,
        address: str | None = None,
        *,
        token: str | None = None,
        operator: str | None = None,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self.address = address_of(address)
        self.operator = operator
        self.etags: dict[str, str] = {}
        self._headers = headers_of(token, operator)
        self._http = httpx.AsyncClient(base_url=self.address, headers=self._headers, transport=transport)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Close the connections."""
        await self._http.aclose()

    async def ask(self, request: Request) -> Any:
        """The answer to ``request``. Raises Problem for a refusal, Unreachable where none comes."""
        try:
            response = await self._http.request(**request.options())
        except httpx.TransportError as failure:
            raise Unreachable(f"{self.address} does not answer: {failure}") from failure
        if etag := response.headers.get("etag"):
            self.etags[request.path] = etag
        return request.decoded(response)

    async def download_recording(self, name: str, file: Path) -> None:
        """Write the recording ``name`` to ``file``. Role: spectator."""
        url = f"{BASE}/recordings/{Request.quoted(name)}"
        async with self._http.stream("GET", url, timeout=httpx.Timeout(30.0)) as response:
            if response.status_code >= 400:
                await response.aread()
                raise problem_of(response.status_code, response.content)
            with file.open("wb") as out:
                async for piece in response.aiter_bytes():
                    await asyncio.to_thread(out.write, piece)

    @asynccontextmanager
    async def desire(
        self,
        desire_class: str,
        params: dict[str, Any] | None = None,
        *,
        intensity: float = 4.0,
        utility: float = 1.0,
        security: bool = False,
        ttl: float = 30.0,
    ) -> AsyncIterator[AsyncHeldDesire]:
        """Desire something for as long as the block lasts.

        The desire is renewed meanwhile and removed at the end; where this program dies it expires within ``ttl``
        seconds. One that the robot has accomplished, or somebody removed, is not created again.
        """
        body = new_desire(desire_class, params or {}, intensity=intensity, utility=utility, security=security, ttl=ttl)
        held = AsyncHeldDesire(self, await self.create_desire(body))
        renewing = asyncio.create_task(self._renew(held.id, ttl), name=f"renew {held.id}")
        try:
            yield held
        finally:
            renewing.cancel()
            await asyncio.wait({renewing})
            await asyncio.shield(self._remove(held.id))

    async def _renew(self, desire: str, ttl: float) -> None:
        while True:
            await asyncio.sleep(ttl / RENEWALS)
            try:
                await self.change_desire(desire, renewal(ttl))
            except Problem:
                return  # it has left
            except Unreachable:
                continue

    async def _remove(self, desire: str) -> None:
        with suppress(Unreachable):  # it expires
            try:
                await self.remove_desire(desire)
            except Problem as problem:
                if problem.status != 404:
                    raise

    @asynccontextmanager
    async def live(self) -> AsyncIterator[AsyncIterator[msgspec.Struct]]:
        """The live stream: records as they come, of the types in ``hbba_client.records.LIVE``.

        While a stream is open the robot attends to telepresence, as for a page. Raises Unreachable.
        """
        headers = with_cookies(self._headers, self._http.cookies)
        try:
            connection = await connect(live_url(self.address, self.operator), additional_headers=headers)
        except InvalidStatus as refusal:
            raise problem_of(refusal.response.status_code, bytes(refusal.response.body)) from None
        except (OSError, InvalidHandshake) as failure:
            raise Unreachable(f"{self.address} does not answer: {failure}") from failure
        async with connection:
            await connection.send(NO_PICTURES)
            yield _messages(connection)


async def _messages(connection: ClientConnection) -> AsyncIterator[msgspec.Struct]:
    async for frame in connection:
        if (message := message_of(frame)) is not None:
            yield message
