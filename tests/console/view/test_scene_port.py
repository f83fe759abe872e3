"""The 3D view on a port of its own: really served, behind the same access rules."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path

import httpx
import pytest
import websockets

from app.base.errors import ConfigError
from app.console.access.auth import COOKIE
from app.console.access.origins import Ports
from app.console.app import create_app
from app.console.server import address_of, listen, listen_for_scene, url_of
from app.program.system import System
from tests.console.program import served
from tests.console.view.test_relay import looking
from tests.patience import PATIENCE_S

TOKEN = "a token of the tests"
HANDSHAKE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


@asynccontextmanager
async def apart(system: System, page: Path, token: str | None = None) -> AsyncIterator[tuple[str, str]]:
    """The console on two ports: the addresses of its page and of its 3D view."""
    with ExitStack() as stack:
        listener = stack.enter_context(listen("127.0.0.1", 0))
        scene = stack.enter_context(listen_for_scene("127.0.0.1", address_of(listener)[1], 0))
        ports = Ports(address_of(listener)[1], address_of(scene)[1])
        app = create_app(system, static_dir=page, token=token, ports=ports, early_view=False)
        async with served(app, listener, scene) as url:
            yield url, url_of(scene)


@pytest.fixture
async def both(system: System, page: Path) -> AsyncIterator[tuple[str, str]]:
    """Without a token."""
    async with apart(system, page) as urls:
        yield urls


@pytest.fixture
async def guarded(system: System, page: Path) -> AsyncIterator[tuple[str, str]]:
    """With a token."""
    async with apart(system, page, TOKEN) as urls:
        yield urls


async def upgrade(scene: str, **headers: str) -> int:
    """Status of the handshake of a pulse."""
    try:
        async with websockets.connect(
            f"{scene.replace('http', 'ws')}/viser/pulse?viewer=abc", proxy=None, additional_headers=headers
        ):
            return 101
    except websockets.InvalidStatus as refusal:
        return refusal.response.status_code


def directives(response: httpx.Response) -> dict[str, str]:
    """The content security policy of an answer, by directive."""
    parts = response.headers["content-security-policy"].split("; ")
    return {name: value for name, _, value in (part.partition(" ") for part in parts)}


async def test_page_and_frame_name_each_other_and_only_the_frame_asks_for_a_process(both: tuple[str, str]) -> None:
    page, scene = both
    async with httpx.AsyncClient(timeout=PATIENCE_S) as client:
        shown, framed, own = [await client.get(url) for url in (f"{page}/", f"{scene}/viser/", f"{page}/viser/")]
    assert directives(shown)["frame-src"] == f"'self' {scene}"
    assert directives(shown)["connect-src"] == f"'self' {scene}"
    assert directives(shown)["frame-ancestors"] == "'self'"
    assert directives(framed)["frame-ancestors"] == page
    assert directives(own)["frame-ancestors"] == "'self'"
    assert framed.headers["origin-agent-cluster"] == "?1"
    assert not any("origin-agent-cluster" in answer.headers for answer in (shown, own))
    assert f'const PAGE = "{page}"' in framed.text
    assert 'const PAGE = "" || location.origin' in own.text


async def test_the_page_learns_the_address_from_the_console(both: tuple[str, str]) -> None:
    page, scene = both
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=page) as client:
        assert (await client.get("/api/v1/scene")).json() == {"url": f"{scene}/viser/"}
        behind_a_proxy = await client.get("/api/v1/scene", headers={"Host": "localhost"})
        assert behind_a_proxy.json() == {"url": None}


async def test_through_another_port_nothing_may_frame_the_view(both: tuple[str, str]) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S) as client:
        framed = await client.get(f"{both[1]}/viser/", headers={"Host": "localhost:1"})
    assert directives(framed)["frame-ancestors"] == "'none'"


async def test_the_second_port_has_the_view_and_its_sign_of_life_and_nothing_else(both: tuple[str, str]) -> None:
    page, scene = both
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=scene) as client:
        alive = await client.get("/viser/health", headers={"Origin": page})
        assert alive.json() == {"status": "ok"}
        assert alive.headers["access-control-allow-origin"] == page
        for path in ("/", "/api/v1/health", "/api/v1/desires", "/api/v1/robot", "/assets/index-1a2b.js", "/panels/x"):
            assert (await client.get(path)).status_code == 404, path
        assert (await client.post("/api/v1/stop", headers={"Origin": scene})).status_code == 404
    async with looking(scene) as viewer:
        await viewer.until(("MeshMessage", None))


async def test_only_pages_of_the_view_itself_open_its_sockets(both: tuple[str, str]) -> None:
    page, scene = both
    assert await upgrade(scene, Origin=scene) == 101
    assert await upgrade(scene, Origin=page) == 403
    assert await upgrade(scene, Origin="http://evil.example") == 403


async def test_a_name_of_others_is_refused_there_too(both: tuple[str, str], guarded: tuple[str, str]) -> None:
    for _, scene in (both, guarded):
        host = {"Host": f"evil.example:{httpx.URL(scene).port}"}
        async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=scene, headers=host) as client:
            for path, headers in (("/viser/", {}), ("/viser/health", {}), ("/viser/pulse", HANDSHAKE)):
                assert (await client.get(path, headers=headers)).status_code == 421


async def test_with_a_token_the_view_asks_for_the_login_of_the_page(guarded: tuple[str, str]) -> None:
    page, scene = guarded
    async with httpx.AsyncClient(timeout=PATIENCE_S) as client:
        assert (await client.get(f"{scene}/viser/")).status_code == 401
        assert await upgrade(scene) == 401
        assert (await client.get(f"{scene}/viser/health")).status_code == 200
        await client.post(f"{page}/api/v1/session", json={"token": TOKEN})
        name = f"{COOKIE}_{httpx.URL(page).port}"
        cookie = f"{name}={client.cookies[name]}"
        # As browsers do, the client sends the cookie to every port of the host.
        assert (await client.get(f"{scene}/viser/")).status_code == 200
        pulse = await websockets.connect(
            f"{scene.replace('http', 'ws')}/viser/pulse?viewer=abc", proxy=None, additional_headers={"Cookie": cookie}
        )
        await client.delete(f"{page}/api/v1/session")
        await pulse.wait_closed()
        assert (pulse.close_code, pulse.close_reason) == (1008, "logged out")
        assert (await client.get(f"{scene}/viser/", headers={"Cookie": cookie})).status_code == 401
        assert await upgrade(scene, Cookie=cookie) == 401
    assert await upgrade(scene, Authorization=f"Bearer {TOKEN}") == 101


def test_the_port_is_the_next_one_or_any_that_is_free() -> None:
    with listen("127.0.0.1", 0) as taken:
        port = address_of(taken)[1]
        with listen_for_scene("127.0.0.1", port - 1, None) as scene:
            assert address_of(scene)[1] not in (port - 1, port)
        with listen_for_scene("127.0.0.1", 65_535, None) as scene:
            assert address_of(scene)[1] > 0


def test_a_port_that_was_asked_for_is_taken_or_refused_with_what_to_do() -> None:
    with listen("127.0.0.1", 0) as taken:
        port = address_of(taken)[1]
        with pytest.raises(ConfigError, match=rf"port {port} .* is taken by another program.*--scene-port"):
            listen_for_scene("127.0.0.1", 8080, port)
        with pytest.raises(ConfigError, match=r"needs a port of its own.*--scene-port 0"):
            listen_for_scene("127.0.0.1", port, port)
