"""Roles: every route and every message needs one, and what they may do is held on REST and on the live stream."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, get_args

import httpx
import pytest
import websockets
from argon2 import PasswordHasher
from fastapi import FastAPI
from fastapi.routing import APIRoute, APIWebSocketRoute

from app.console.access.auth import COOKIE, GUARDED, OPEN_PATHS
from app.console.access.origins import Ports
from app.console.access.passwords import hash_of
from app.console.access.roles import MESSAGES, OPEN_OPERATIONS, OPERATIONS, SOCKETS, Role, needed_role
from app.console.app import create_app
from app.console.live import protocol
from app.console.rest.routing import router
from app.console.view.scene_port import scene_app
from app.program.system import System
from tests.console.live_client import Page, page
from tests.console.program import Body, served
from tests.patience import PATIENCE_S

WORDS = {role: f"the {role}'s secret" for role in Role}
#: What needs an operator on every kind of thing, and what needs a supervisor.
CHEAP = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
PASSWORDS = tuple((role, hash_of(word, CHEAP)) for role, word in WORDS.items())


@pytest.fixture
def app(system: System, page: Path) -> FastAPI:
    """The console with a password for each role."""
    return create_app(system, static_dir=page, passwords=PASSWORDS, early_view=False)


@asynccontextmanager
async def logged_in(url: str, role: Role) -> AsyncIterator[httpx.AsyncClient]:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        answer = await client.post("/session", json={"token": WORDS[role]})
        assert answer.json() == {"authenticated": True, "token_needed": True, "role": role.value}
        yield client


@asynccontextmanager
async def live_page(url: str, role: Role, operator: str = "Ann") -> AsyncIterator[Page]:
    async with page(url, operator, additional_headers={"Authorization": f"Bearer {WORDS[role]}"}) as opened:
        yield opened


def operations(app: FastAPI) -> list[tuple[str, str, dict[str, Any]]]:
    """Path, method and description of each operation."""
    paths: dict[str, dict[str, dict[str, Any]]] = app.openapi()["paths"]
    return [(path, method, operation) for path, each in paths.items() for method, operation in each.items()]


def test_every_operation_needs_a_role_or_is_open_and_the_table_has_no_other(app: FastAPI) -> None:
    known = {operation["operationId"]: (path, operation) for path, _, operation in operations(app)}
    assert set(known) == set(OPERATIONS) | OPEN_OPERATIONS
    assert not set(OPERATIONS) & OPEN_OPERATIONS
    for name, (path, operation) in known.items():
        assert operation.get("x-role") == OPERATIONS.get(name), name
        assert (path in OPEN_PATHS) == (name in OPEN_OPERATIONS), name


def test_a_route_without_a_role_cannot_be_made() -> None:
    routes = router("robot")
    with pytest.raises(KeyError, match="rob_the_bank"):

        @routes.post("/bank")
        async def rob_the_bank() -> None: ...


def test_what_a_spectator_may_ask_for_reads_but_for_the_stop_and_for_questions_with_a_body(app: FastAPI) -> None:
    """A route that changes something needs another role, or a word here why not."""
    changing = {
        operation["operationId"]
        for _, method, operation in operations(app)
        if method != "get" and needed_role(operation["operationId"]) is Role.SPECTATOR
    }
    assert changing == {"latch_e_stop", "find_camera_point", "find_scene_point", "plan_route", "validate_tour"}


def test_every_other_route_only_gives_files_and_every_socket_needs_a_role(app: FastAPI) -> None:
    scene = scene_app(app.state.view, Ports(8080, 8081))
    for route in (*app.routes, *scene.routes):
        if isinstance(route, APIWebSocketRoute):
            assert route.path in SOCKETS, route.path
        elif isinstance(route, APIRoute) and not route.include_in_schema:
            assert route.methods == {"GET"}, route.path
    described = {f"{path}" for path, *_ in operations(app)}
    assert all(any(path.startswith(prefix) for prefix in GUARDED) for path in described | set(SOCKETS))


def test_every_message_of_a_page_needs_a_role() -> None:
    tags = {str(struct.__struct_config__.tag) for struct in get_args(protocol.FromPage)}
    assert set(MESSAGES) == tags | {"voice"}


async def test_each_role_may_do_what_it_may_and_is_refused_the_rest_in_words(app: FastAPI) -> None:
    """All operations, with names of nothing and bodies of nothing: each either passes the door of roles or not."""
    async with served(app) as url:
        for role in Role:
            async with logged_in(url, role) as client:
                for path, method, operation in operations(app):
                    needed = OPERATIONS.get(operation["operationId"])
                    if needed is None or role.covers(needed):
                        continue
                    answer = await client.request(method, path.removeprefix("/api/v1"))
                    assert answer.status_code == 403, (role, path)
                    problem = answer.json()
                    assert problem["type"] == "urn:hbba:problem:role-needed"
                    assert (problem["role"], problem["needed"]) == (role.value, needed.value)
                    assert f"needs the role {needed}; you are logged in as a" in problem["detail"]


async def test_a_spectator_sees_and_stops_and_changes_nothing(app: FastAPI, system: System, body: Body) -> None:
    async with served(app) as url, logged_in(url, Role.SPECTATOR) as client:
        assert (await client.get("/desires")).status_code == 200
        before = system.workspace.desires()
        new = {"class": "FindQRCodes", "intensity": 1, "utility": 1}
        assert (await client.post("/desires", json=new)).status_code == 403
        assert system.workspace.desires() == before
        async with live_page(url, Role.SPECTATOR) as spectator:
            assert (await spectator.until("hello"))["role"] == "spectator"
            await spectator.drive(1.0)
            notice = await spectator.until("notice")
            assert notice["text"] == "You are logged in as a spectator: drive needs the role operator."
            await spectator.send("ask_control")
            await spectator.until("notice", lambda it: "ask control" in it["text"])
            await spectator.send("take_control")
            await spectator.until("notice", lambda it: "supervisor" in it["text"])
            status = await spectator.until("status")
            assert status["driver"] is None
            await spectator.send("e_stop")
            await spectator.send("clear_e_stop")
            await spectator.until("notice", lambda it: "clear e stop" in it["text"])
        assert body.e_stopped


async def test_a_stop_of_another_is_released_by_a_supervisor_alone(app: FastAPI, system: System, body: Body) -> None:
    async with (
        served(app) as url,
        logged_in(url, Role.OPERATOR) as operator,
        logged_in(url, Role.OPERATOR) as other,
        logged_in(url, Role.SUPERVISOR) as supervisor,
    ):

        async def release(client: httpx.AsyncClient) -> httpx.Response:
            return await client.delete("/stop", params={"seen": system.clock.now()})

        assert (await operator.post("/stop")).status_code == 200
        refusal = await release(other)
        assert (refusal.status_code, refusal.json()["type"]) == (403, "urn:hbba:problem:stop-of-another")
        assert body.e_stopped
        assert (await release(operator)).status_code == 200
        assert not body.e_stopped
        assert (await operator.post("/stop")).status_code == 200
        assert (await other.post("/stop")).status_code == 200
        assert (await release(operator)).status_code == 403, "another pressed it too"
        assert (await release(supervisor)).status_code == 200
        assert not body.e_stopped


async def test_a_face_is_not_for_spectators_since_it_shows_the_key_for_visitors(app: FastAPI) -> None:
    async with served(app) as url:
        for role in Role:
            headers = {"Authorization": f"Bearer {WORDS[role]}"}
            opening = websockets.connect(
                f"{url.replace('http', 'ws')}/api/v1/face", additional_headers=headers, proxy=None
            )
            if role is Role.SPECTATOR:
                with pytest.raises(websockets.InvalidStatus, match="403"):
                    await opening
            else:
                await (await opening).close()


async def test_a_wrong_password_opens_nothing_and_a_logout_ends_the_session_here(app: FastAPI) -> None:
    async with served(app) as url, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        wrong = await client.post("/session", json={"token": "nobody's secret"})
        assert (wrong.status_code, wrong.json()["type"]) == (401, "urn:hbba:problem:wrong-token")
        await client.post("/session", json={"token": WORDS[Role.OPERATOR]})
        (kept,) = [cookie for cookie in client.cookies.jar if cookie.name.startswith(COOKIE)]
        assert (await client.get("/session")).json()["role"] == "operator"
        await client.delete("/session")
        kept_cookie = {"Cookie": f"{kept.name}={kept.value}"}
        assert (await client.get("/desires", headers=kept_cookie)).status_code == 401


async def test_the_token_is_a_supervisor_s_beside_passwords(system: System, page: Path) -> None:
    app = create_app(system, static_dir=page, token="a long token", passwords=PASSWORDS, early_view=False)
    async with served(app) as url, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        for secret, role in (("a long token", "supervisor"), (WORDS[Role.SPECTATOR], "spectator")):
            answer = await client.get("/session", headers={"Authorization": f"Bearer {secret}"})
            assert answer.json()["role"] == role
