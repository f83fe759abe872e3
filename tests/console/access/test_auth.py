"""Who may enter, and from which page."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import websockets

from app.base.errors import ConfigError
from app.console.access.auth import COOKIE, is_loopback
from app.console.access.origins import host_name
from app.console.app import create_app
from app.console.server import listen, url_of
from app.program.system import System
from tests.console.program import served
from tests.patience import PATIENCE_S

TOKEN = "correct horse battery"
LIVE = "/api/v1/live"


@pytest.fixture
async def guarded(system: System, page: Path) -> AsyncIterator[str]:
    """The console, served with a token."""
    async with served(create_app(system, static_dir=page, token=TOKEN, early_view=False)) as url:
        yield url


async def status_of_live(url: str, **options: Any) -> int:
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
        ("evil.example@localhost", False),
        ("localhost/@evil.example", False),
        ("localhost:80:80", False),
        ("localhost evil.example", False),
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


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "http://127.0.0.1:9",
        "http://127.0.0.1.evil:80",
        "https://{host}",
        "http://{host}@evil.example",
    ],
)
async def test_pages_of_others_change_nothing_and_hear_nothing(url: str, origin: str) -> None:
    origin = origin.format(host=url.removeprefix("http://"))
    headers = {"Origin": origin}
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1", headers=headers) as client:
        assert (await client.post("/stop")).status_code == 403
        assert (await client.delete("/stop")).status_code == 403
        assert (await client.patch("/resources/cpu", json={"capacity": 1})).status_code == 403
        assert (await client.get("/desires")).status_code == 200
    assert await status_of_live(url, origin=origin) == 403


async def test_our_own_page_may(url: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1", headers={"Origin": url}) as client:
        assert (await client.post("/stop")).status_code == 200
    assert await status_of_live(url, origin=url) == 101
    assert await status_of_live(url) == 101


async def test_with_a_token_nothing_is_open_but_the_page_the_login_and_the_sign_of_life(guarded: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=guarded) as client:
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
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{guarded}/api/v1") as client:
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
        name = f"{COOKIE}_{httpx.URL(guarded).port}"
        opening = {"Cookie": f"a=b; {name}={client.cookies[name]}"}
        assert await status_of_live(guarded, additional_headers=opening) == 101
        assert (await client.delete("/session")).status_code == 204
        assert (await client.get("/desires")).status_code == 401
        assert (await client.get("/desires", headers=opening)).status_code == 401
        assert await status_of_live(guarded, additional_headers=opening) == 401


async def test_each_login_has_a_session_of_its_own(guarded: str) -> None:
    async with (
        httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{guarded}/api/v1") as one,
        httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{guarded}/api/v1") as other,
    ):
        for client in (one, other):
            await client.post("/session", json={"token": TOKEN})
        assert dict(one.cookies) != dict(other.cookies)
        await one.delete("/session")
        assert (await other.get("/desires")).status_code == 200


async def test_a_logout_ends_the_session_s_websockets_and_no_others(guarded: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{guarded}/api/v1") as client:
        await client.post("/session", json={"token": TOKEN})
        cookie = {"Cookie": "; ".join(f"{name}={value}" for name, value in client.cookies.items())}
        bearer = {"Authorization": f"Bearer {TOKEN}"}
        address = guarded.replace("http", "ws")
        sockets = [
            await websockets.connect(
                address + path, proxy=None, open_timeout=None, additional_headers=headers, max_queue=None
            )
            for path, headers in ((LIVE, cookie), ("/viser/pulse", cookie), (LIVE, bearer))
        ]
        await client.delete("/session")
        for gone in sockets[:2]:
            await gone.wait_closed()
            assert (gone.close_code, gone.close_reason) == (1008, "logged out")
        await (await sockets[2].ping())
        await sockets[2].close()


async def test_a_cookie_over_tls_is_for_tls_alone(system: System, page: Path) -> None:
    app = create_app(system, static_dir=page, token=TOKEN, early_view=False)
    transport = httpx.ASGITransport(app)
    for scheme, secure in (("http", False), ("https", True)):
        async with httpx.AsyncClient(transport=transport, base_url=f"{scheme}://localhost/api/v1") as client:
            cookie = (await client.post("/session", json={"token": TOKEN})).headers["set-cookie"]
        assert ("secure" in cookie.lower()) is secure


async def test_wrong_tokens_are_slowed_however_they_are_shown_and_of_their_address_alone(
    system: System, page: Path
) -> None:
    app = create_app(system, static_dir=page, token=TOKEN, early_view=False)

    def client(address: str) -> httpx.AsyncClient:
        transport = httpx.ASGITransport(app, client=(address, 1))
        return httpx.AsyncClient(transport=transport, base_url="http://localhost/api/v1")

    right = {"Authorization": f"Bearer {TOKEN}"}
    async with client("192.0.2.1") as guessing, client("192.0.2.2") as other, client("192.0.2.3") as third:
        await other.post("/session", json={"token": TOKEN})
        statuses = [
            (await guessing.post("/session", json={"token": "guess number"})).status_code,
            *[(await guessing.get("/desires", headers={"Authorization": f"Bearer {n}"})).status_code for n in range(5)],
        ]
        assert statuses == [401] * 6
        slowed = await guessing.get("/desires", headers=right)
        assert slowed.status_code == 429
        assert slowed.json()["type"] == "urn:hbba:problem:too-many-attempts"
        assert int(slowed.headers["retry-after"]) == 1
        assert (await guessing.post("/session", json={"token": TOKEN})).status_code == 429
        assert (await guessing.get("/health")).status_code == 200
        assert (await other.get("/desires")).status_code == 200
        assert (await third.post("/session", json={"token": TOKEN})).status_code == 200


@pytest.mark.parametrize(
    ("host", "answers"),
    [
        ("localhost:8080", True),
        ("192.0.2.7:8080", True),
        ("[2001:db8::1]:8080", True),
        (socket.gethostname(), True),
        (f"{socket.gethostname().partition('.')[0].upper()}.local:8080", True),
        ("robot.example", True),
        ("Robot.Example.:443", True),
        ("evil.example", False),
        ("robot.example.evil.example", False),
        ("", False),
    ],
)
async def test_with_a_token_only_addresses_and_names_of_this_computer_are_answered(
    system: System, page: Path, host: str, answers: bool
) -> None:
    app = create_app(system, static_dir=page, token=TOKEN, host_names=["robot.example"], early_view=False)
    headers = {"Host": host, "Authorization": f"Bearer {TOKEN}"}
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost/api/v1") as client:
        response = await client.get("/desires", headers=headers)
    assert response.status_code == (200 if answers else 421)
    assert answers or "--host-name" in response.json()["detail"]


@pytest.mark.parametrize(
    ("header", "name"),
    [("Robot:1", "robot"), ("[::1]:8080", "::1"), ("a@b", ""), ("a b", ""), ("a:b", ""), ("-", ""), ("é", "")],
)
def test_a_host_is_read_strictly(header: str, name: str) -> None:
    assert host_name(header) == name


async def test_a_mistake_of_ours_is_a_problem_with_security_headers_too(system: System, page: Path) -> None:
    app = create_app(system, static_dir=page, early_view=False)

    @app.get("/api/v1/broken")
    async def broken() -> None:
        raise ZeroDivisionError

    transport = httpx.ASGITransport(app, raise_app_exceptions=False)
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost/api/v1") as client:
        response = await client.get("/broken")
    assert response.status_code == 500
    assert response.headers["content-type"] == "application/problem+json"
    assert response.headers["x-content-type-options"] == "nosniff"
    assert response.json()["type"] == "urn:hbba:problem:mistake-of-ours"
    assert "Zero" not in response.text


async def test_a_bearer_token_opens(guarded: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{guarded}/api/v1") as client:
        right = {"Authorization": f"Bearer {TOKEN}"}
        assert (await client.get("/desires", headers=right)).status_code == 200
        for wrong in (f"Bearer {TOKEN}x".encode(), f"Basic {TOKEN}".encode(), b"Bearer", "Bearer é".encode("latin-1")):
            assert (await client.get("/desires", headers={b"Authorization": wrong})).status_code == 401
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


@pytest.mark.parametrize(("host", "loopback"), [("127.8.9.1", True), ("0.0.0.0", False), ("example.org", False)])
def test_loopback_addresses(host: str, loopback: bool) -> None:
    assert is_loopback(host) is loopback


def test_a_taken_port_is_refused_before_anything_starts() -> None:
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
        reading = await websockets.connect(address, proxy=None, open_timeout=None, max_queue=None, close_timeout=0.1)
        stalled = await websockets.connect(address, proxy=None, open_timeout=None, max_queue=1, close_timeout=0.1)
        stalled.transport.pause_reading()
        await reading.recv()
        began = asyncio.get_running_loop().time()
    assert asyncio.get_running_loop().time() - began < 1.0
    await reading.close()
    await stalled.close()
