"""Connections that only hold their place, over real sockets."""

from __future__ import annotations

import asyncio
import errno
import logging
import socket
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest
import websockets
from fastapi import FastAPI
from websockets.typing import Origin

from app.console import server
from app.console.access import connection_limits, protocols
from tests.console.program import served
from tests.console.raw import Raw, connected, request

HEALTH = request("GET /api/v1/health")
HALF_HEADER = HEALTH[:-2]
HALF_BODY = request("POST /api/v1/desires", "Content-Length: 60000", body=b"{")


async def trickle(raw: Raw, part: bytes) -> None:
    """Send a little for ever."""
    while True:
        await raw.send(part)
        await asyncio.sleep(0.01)


async def answers(url: str) -> bool:
    """Whether the console serves a newcomer."""
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=None) as client:
        return (await client.get("/health")).status_code == 200


@pytest.mark.parametrize(("start", "part"), [(HALF_HEADER, b"X: y\r\n"), (HALF_BODY, b" ")])
async def test_a_trickled_request_ends_in_its_time(
    url: str, start: bytes, part: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(protocols, "HEADER_WITHIN_S", 0.2)
    monkeypatch.setattr(protocols, "BODY_WITHIN_S", 0.2)
    async with connected(url) as raw:
        await raw.send(start)
        trickling = asyncio.create_task(trickle(raw, part))
        try:
            status, said = await raw.answer()
        finally:
            trickling.cancel()
        assert status == 408
        assert b"urn:hbba:problem:too-slow" in said


async def test_a_silent_connection_ends(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocols, "HEADER_WITHIN_S", 0.05)
    async with connected(url) as raw:
        assert await raw.rest() == b""


@pytest.mark.parametrize("after", [b"", HALF_HEADER])
async def test_a_connection_that_was_served_ends_in_its_time(
    app: FastAPI, after: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In that between two requests; or in that of a header, where there is half of one."""
    monkeypatch.setattr(server, "KEEP_ALIVE_S", 0.05)
    async with served(app) as url, connected(url) as raw:
        await raw.send(HEALTH)
        said = await raw.reader.readuntil(b"}")
        assert said.startswith(b"HTTP/1.1 200")
        monkeypatch.setattr(protocols, "HEADER_WITHIN_S", 0.05)
        await raw.send(after)
        assert (b"408" in await raw.rest()) == bool(after)


async def test_an_answer_that_is_not_read_is_given_up(url: str, page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ended, end = asyncio.Event(), protocols.BoundedHttp.connection_lost

    def connection_lost(self: protocols.BoundedHttp, exc: Exception | None) -> None:
        end(self, exc)
        ended.set()

    monkeypatch.setattr(protocols.BoundedHttp, "connection_lost", connection_lost)
    monkeypatch.setattr(protocols, "STALLED_AFTER_S", 0.05)
    (page / "assets" / "large.js").write_bytes(b" " * 30_000_000)  # more than the kernel's buffers hold
    async with connected(url) as raw:
        await raw.send(request("GET /assets/large.js"))
        await raw.reader.readexactly(1)
        raw.reader._transport.pause_reading()  # type: ignore[attr-defined]
        await ended.wait()


async def test_waiting_connections_keep_no_other_out(app: FastAPI, monkeypatch: pytest.MonkeyPatch) -> None:
    """There is room for 64: of 200 half requests and silent connections, those that wait longest give way."""
    monkeypatch.setattr(server, "most_connections", lambda: connection_limits.FEWEST_CONNECTIONS)
    async with served(app) as url, AsyncExitStack() as stack:
        for number in range(200):
            raw = await stack.enter_async_context(connected(url))
            await raw.send((b"", HALF_HEADER, HALF_BODY)[number % 3])
        assert await answers(url)
        live = await websockets.connect(
            url.replace("http", "ws") + "/api/v1/live", proxy=None, open_timeout=None, max_queue=None
        )
        async with live:
            for _ in range(100):
                await stack.enter_async_context(connected(url))
            assert await answers(url)
            await live.ping()
            await live.recv()  # it was let in: it does not give way


async def test_websockets_leave_room_for_requests(app: FastAPI, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "most_connections", lambda: connection_limits.FEWEST_CONNECTIONS)
    async with served(app) as url, AsyncExitStack() as stack:
        address = url.replace("http", "ws") + "/viser/pulse"
        for _ in range(connection_limits.FEWEST_CONNECTIONS - connection_limits.KEPT_FOR_REQUESTS):
            await stack.enter_async_context(websockets.connect(address, proxy=None, open_timeout=None))
        with pytest.raises(websockets.InvalidStatus) as refused:
            await websockets.connect(address, proxy=None, open_timeout=None)
        assert refused.value.response.status_code == 503
        assert refused.value.response.headers["Retry-After"] == "5"
        assert await answers(url)


async def test_without_descriptors_it_is_said_once_and_tried_again(
    app: FastAPI, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """asyncio's own accepting logs a traceback thousands of times a second."""
    tries, free = asyncio.Queue[None](), asyncio.Event()
    accept = asyncio.get_running_loop().sock_accept

    async def exhausted(listener: socket.socket) -> Any:
        if free.is_set():
            return await accept(listener)
        tries.put_nowait(None)
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(asyncio.get_running_loop(), "sock_accept", exhausted)
    monkeypatch.setattr(server, "RETRY_S", 0.001)
    monkeypatch.setattr(server, "CALM_AFTER_S", 0.0)
    with caplog.at_level(logging.INFO, "hbba.console"):
        async with served(app) as url:
            for _ in range(20):
                await tries.get()
            free.set()
            assert await answers(url)
    said = [record.getMessage() for record in caplog.records if record.name == "hbba.console"]
    assert said == [
        "no connection can be accepted: Too many open files; the longest waiting one is closed",
        "connections are accepted again",
    ]


async def test_a_text_that_is_not_utf_8_is_one_line_in_the_log(url: str, caplog: pytest.LogCaptureFixture) -> None:
    address = url.replace("http", "ws") + "/api/v1/live"
    async with websockets.connect(address, proxy=None, open_timeout=None, max_queue=None) as live:
        await live.send(b"\xff\xfe", text=True)
        await live.wait_closed()
        assert live.close_code == 1007
    said = [record for record in caplog.records if record.name.startswith("uvicorn")]
    assert [record.levelname for record in said] == ["WARNING"]
    assert said[0].exc_info is None


async def test_a_refused_websocket_is_no_line_in_the_log(url: str, caplog: pytest.LogCaptureFixture) -> None:
    with pytest.raises(websockets.InvalidStatus) as refused:
        await websockets.connect(
            url.replace("http", "ws") + "/api/v1/live",
            proxy=None,
            open_timeout=None,
            origin=Origin("http://evil.example"),
        )
    assert refused.value.response.status_code == 403
    assert b"foreign-origin" in (refused.value.response.body or b"")
    assert await answers(url)
    assert not [record for record in caplog.records if record.name.startswith("uvicorn")]
