"""Who may enter, and from which page."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest
import websockets

from app.console.app import create_app
from app.console.security import COOKIE, Door, check_token, is_loopback, new_token
from app.console.server import listen, url_of
from app.errors import ConfigError
from app.system import System
from tests.console.program import served

TOKEN = "correct horse battery"
LIVE = "/api/v1/live"


@pytest.fixture
async def guarded(system: System, page: Path) -> AsyncIterator[str]:
    """The console, served with a token."""
    async with served(create_app(system, static_dir=page, token=TOKEN, early_view=False)) as url:
        yield url


async def status_of_live(url: str, **options: object) -> int:
    """101 where the live stream opens, else the status of the refusal."""
    try:
        async with websockets.connect(
            url.replace("http", "ws") + LIVE, proxy=None, close_timeout=1, max_queue=None, **options
        ):
            return 101
    except websockets.InvalidStatus as refusal:
        return refusal.response.status_code


@pytest.mark.parametrize(
    ("host", "answers"),
    [
        ("localhost:8080", True),
        ("LOCALHOST", True),
        ("127.0.0.1:1", True),
        ("[::1]:8080", True),
        ("robot.example", False),
        ("127.0.0.1.example:8080", False),
        ("localhost.example", False),
        ("10.0.0.5:8080", False),
        ("", False),
        ("[::1", False),
    ],
)
async def test_without_a_token_only_names_of_this_computer_are_answered(
    client: httpx.AsyncClient, host: str, answers: bool
) -> None:
    """A name that an attacker's DNS points at 127.0.0.1 (DNS rebinding) opens nothing."""
    response = await client.get("/desires", headers={"Host": host})
    assert response.status_code == (200 if answers else 421)
    if not answers:
        assert response.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:9", "http://127.0.0.1.evil:80"])
async def test_pages_of_others_change_nothing_and_hear_nothing(url: str, origin: str) -> None:
    headers = {"Origin": origin}
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", headers=headers) as client:
        assert (await client.post("/robot/e-stop")).status_code == 403
        assert (await client.delete("/robot/e-stop")).status_code == 403
        assert (await client.patch("/resources/cpu", json={"capacity": 1})).status_code == 403
        assert (await client.get("/desires")).status_code == 200
    assert await status_of_live(url, origin=origin) == 403


async def test_our_own_page_may(url: str) -> None:
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", headers={"Origin": url}) as client:
        assert (await client.post("/robot/e-stop")).status_code == 200
    assert await status_of_live(url, origin=url) == 101
    assert await status_of_live(url) == 101


async def test_with_a_token_nothing_is_open_but_the_page_the_login_and_the_sign_of_life(guarded: str) -> None:
    async with httpx.AsyncClient(base_url=guarded) as client:
        assert (await client.get("/")).status_code == 200
        assert (await client.get("/api/v1/health")).status_code == 200
        for path in ("/api/v1/desires", "/api/v1/session", "/api/v1/openapi.json", "/viser/", "/api/nonsense"):
            response = await client.get(path)
            assert response.status_code == 401, path
            assert response.headers["www-authenticate"].startswith("Bearer")
            assert response.json()["type"] == "urn:hbba:problem:login-needed"
    assert await status_of_live(guarded) == 401
    assert await status_of_live(guarded, additional_headers={"Cookie": f"{COOKIE}=0"}) == 401


async def test_a_login_gives_a_cookie_that_opens(guarded: str) -> None:
    async with httpx.AsyncClient(base_url=f"{guarded}/api/v1") as client:
        wrong = await client.post("/session", json={"token": "correct horse batterx"})
        assert wrong.status_code == 401
        assert "set-cookie" not in wrong.headers
        right = await client.post("/session", json={"token": TOKEN})
        assert right.status_code == 200
        cookie = right.headers["set-cookie"].lower()
        assert "httponly" in cookie
        assert "samesite=strict" in cookie
        assert TOKEN not in cookie
        assert (await client.get("/desires")).status_code == 200
        value = client.cookies[COOKIE]
        assert await status_of_live(guarded, additional_headers={"Cookie": f"a=b; {COOKIE}={value}"}) == 101
        assert (await client.delete("/session")).status_code == 204
        assert (await client.get("/desires")).status_code == 401


async def test_a_bearer_token_opens(guarded: str) -> None:
    async with httpx.AsyncClient(base_url=f"{guarded}/api/v1") as client:
        right = {"Authorization": f"Bearer {TOKEN}"}
        assert (await client.get("/desires", headers=right)).status_code == 200
        for wrong in (f"Bearer {TOKEN}x", f"Basic {TOKEN}", "Bearer", "Bearer é".encode("latin-1")):
            assert (await client.get("/desires", headers={"Authorization": wrong})).status_code == 401
    assert await status_of_live(guarded, additional_headers=right) == 101


async def test_every_answer_carries_its_security_headers(client: httpx.AsyncClient) -> None:
    api = await client.get("/desires")
    assert api.headers["x-content-type-options"] == "nosniff"
    assert api.headers["cache-control"] == "no-store"
    page = await client.get("http://127.0.0.1:8080/")
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert "unsafe-eval" not in page.headers["content-security-policy"]
    assert page.headers["cache-control"] == "no-cache"
    asset = await client.get("http://127.0.0.1:8080/assets/index-1a2b.js")
    assert "immutable" in asset.headers["cache-control"]
    refused = await client.get("/desires", headers={"Host": "evil"})
    assert refused.headers["x-content-type-options"] == "nosniff"


async def test_a_large_body_is_not_read(client: httpx.AsyncClient) -> None:
    large = await client.post("/desires", content=b"x" * 70_000)
    assert large.status_code == 413
    assert large.json()["type"] == "urn:hbba:problem:body-too-large"

    async def endless() -> AsyncIterator[bytes]:
        yield b"x"

    unknown = await client.post("/desires", content=endless())
    assert unknown.status_code == 411


def test_beyond_loopback_a_token_is_a_must() -> None:
    with pytest.raises(ConfigError, match="needs a token"):
        check_token(None, "0.0.0.0")
    with pytest.raises(ConfigError, match="at least 8"):
        check_token("short", "127.0.0.1")
    assert check_token(None, "127.0.0.1") is None
    assert check_token(None, "::1") is None
    token = new_token()
    assert check_token(token, "0.0.0.0") == token
    assert len(token) >= 20
    assert token != new_token()


def test_the_cookie_tells_nothing_of_the_token_and_outlives_a_restart() -> None:
    assert Door(TOKEN).cookie == Door(TOKEN).cookie
    assert Door(TOKEN).cookie != Door(TOKEN + "x").cookie
    assert Door(None).cookie is None


@pytest.mark.parametrize(("host", "loopback"), [("127.8.9.1", True), ("0.0.0.0", False), ("example.org", False)])
def test_loopback_is_told(host: str, loopback: bool) -> None:
    assert is_loopback(host) is loopback


def test_a_taken_port_is_told_before_anything_starts() -> None:
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        assert url_of(first) == f"http://127.0.0.1:{port}"
        with pytest.raises(ConfigError, match=f"port {port} .* taken .*--port"):
            listen("127.0.0.1", port)
    with pytest.raises(ConfigError, match="no address of this computer"):
        listen("203.0.113.7", 0)


async def test_the_end_comes_within_a_second_though_sockets_are_open(system: System, page: Path) -> None:
    async with served(create_app(system, static_dir=page, early_view=False)) as url:
        address = url.replace("http", "ws") + LIVE
        reading = await websockets.connect(address, proxy=None, max_queue=None, close_timeout=0.1)
        stalled = await websockets.connect(address, proxy=None, max_queue=1, close_timeout=0.1)
        stalled.transport.pause_reading()
        await reading.recv()
        began = asyncio.get_running_loop().time()
    assert asyncio.get_running_loop().time() - began < 1.0
    await reading.close()
    await stalled.close()
