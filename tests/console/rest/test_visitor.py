"""Visitors' phones: the key of a run opens their page's own data and presses, and nothing else."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import websockets

from app.console.access.auth import VISITOR_COOKIE, VISITOR_PATHS
from app.console.app import create_app
from app.console.live.messages import VisitorLink
from app.console.live.tour_visitors import MOST_OF_ONE
from app.console.rest.visitor import PRESSES_AT_ONCE
from app.messages import Speech
from app.program.system import System
from app.tours import media_content
from tests.console.answers import answered, is_problem
from tests.console.live.test_asyncapi import check
from tests.console.program import served
from tests.console.rest.test_tour_run import TOUR, there
from tests.patience import PATIENCE_S
from tests.tours.tours import ARM

TOKEN = "correct horse battery"
OPERATOR = {"Authorization": f"Bearer {TOKEN}"}
PICTURE = b"\xff\xd8\xff picture"
#: A stop that shows a picture, and one that shows it only in an answer.
SHOWS = {"show": {"file": "media/arm.jpg", "alt": {"en": "An orange arm"}}}

__all__ = ["there"]


@pytest.fixture
async def url(system: System, page: Path) -> AsyncIterator[str]:
    """The console, served with a token."""
    app = create_app(system, static_dir=page, token=TOKEN, early_view=False)
    async with served(app) as url:
        yield url


@pytest.fixture
async def client(url: str) -> AsyncIterator[httpx.AsyncClient]:
    """An operator."""
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", headers=OPERATOR, timeout=PATIENCE_S) as operator:
        yield operator


@pytest.fixture
async def phone(url: str) -> AsyncIterator[httpx.AsyncClient]:
    """A visitor's, not let in yet."""
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=PATIENCE_S) as phone:
        yield phone


async def lead(client: httpx.AsyncClient, **more: Any) -> str:
    """Have a tour wait for visitors, however long that takes; returns the key of its run."""
    stops = [ARM | {"do": [SHOWS]}]
    await client.put("/tours/new-tour", json=TOUR | {"stops": stops} | more)
    assert (await client.post("/tours/new-tour/run", json={"begin": "visitors"})).status_code == 200
    return await key_of(client)


async def key_of(client: httpx.AsyncClient) -> str:
    link = answered(await client.get("/tour-run/visitors"), VisitorLink)
    return link.url.partition("#key=")[2]


async def enter(phone: httpx.AsyncClient, key: str) -> httpx.Response:
    return await phone.post("/visitor/session", json={"key": key})


def cookie(phone: httpx.AsyncClient) -> dict[str, str]:
    """As a header, which goes wherever a test sends it, whatever the cookie's path is."""
    return {"Cookie": "; ".join(f"{each.name}={each.value}" for each in phone.cookies.jar)}


async def test_a_key_opens_presses_and_pictures_and_no_other_route(
    client: httpx.AsyncClient, phone: httpx.AsyncClient, url: str, there: None
) -> None:
    is_problem(await phone.get("/visitor/media/media/arm.jpg"), 401, "login-needed")
    is_problem(await enter(phone, "guess"), 401, "wrong-key")
    key = await lead(client)
    is_problem(await phone.get("/visitor/session"), 401, "login-needed")
    entered = await enter(phone, key)
    assert (await phone.get("/visitor/session")).status_code == 204
    assert entered.status_code == 204
    (line,) = entered.headers.get_list("set-cookie")
    assert line.startswith(VISITOR_COOKIE)
    fields = {field.strip().lower() for field in line.split(";")[1:]}
    assert {"httponly", "samesite=strict", "path=/api/v1/visitor"} <= fields
    assert key not in line
    brought = cookie(phone)

    document = (await client.get("/openapi.json")).json()
    opened, tried = set(), 0
    async with httpx.AsyncClient(base_url=url, headers=brought, timeout=PATIENCE_S) as thief:
        for path, operations in document["paths"].items():
            for method in operations:
                address = path.replace("{", "").replace("}", "")
                answer = await thief.request(method.upper(), address, json={} if method != "get" else None)
                tried += 1
                if answer.status_code != 401:
                    opened.add((method, path))
        for address in (
            *("/viser/", "/panels/", "/api/v1/openapi.json", "/api/v1/live.json", "/api/v1/docs", "/api/v1/visitor"),
            *("/api/v1/visitorx", "/api/v1/visitor%2F..%2Fdesires", "/api/v1//visitor/live", "/api/nonsense"),
        ):
            answer = await thief.get(address)
            tried += 1
            # What is below its own paths and is no route is not there; all else is closed.
            expected = 404 if answer.request.url.path.startswith(VISITOR_PATHS) else 401
            assert answer.status_code == expected, address
        # As an operator's token or session, it is nothing.
        value = brought["Cookie"].partition("=")[2]
        for wrong in ({"Authorization": f"Bearer {key}"}, {"Cookie": f"hbba_session_{httpx.URL(url).port}={value}"}):
            assert (await thief.get("/api/v1/desires", headers=wrong)).status_code == 401
    assert tried > 80
    assert opened == {
        *(("get", "/api/v1/health"), ("post", "/api/v1/session"), ("delete", "/api/v1/session")),
        *(("post", "/api/v1/visitor/session"), ("post", "/api/v1/visitor/press")),
        *(("get", "/api/v1/visitor/session"), ("get", "/api/v1/visitor/media/{file}")),
    }
    for stream in ("/api/v1/live", "/api/v1/face", "/viser/pulse", "/viser"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await websockets.connect(url.replace("http", "ws") + stream, proxy=None, additional_headers=brought)
        assert refused.value.response.status_code == 401, stream
    assert (await client.get("/tour-run")).json()["progress"]["waits"], "the tour waits as before"


async def test_a_phone_sees_presses_and_is_out_when_the_run_is_over(
    client: httpx.AsyncClient, phone: httpx.AsyncClient, url: str, system: System, there: None
) -> None:
    key = await lead(client)
    await enter(phone, key)
    stream = url.replace("http", "ws") + "/api/v1/visitor/live"
    async with (
        asyncio.timeout(PATIENCE_S),
        websockets.connect(stream, proxy=None, additional_headers=cookie(phone)) as live,
    ):
        view = json.loads(await live.recv())
        check("visitor", view)
        assert (view["state"], view["buttons"], view["title"]) == ("idle", ["start"], {"en": "The lab"})
        said = Speech(
            system.clock.now(), "speaking", "One moment.", 0, 0, viseme="open", language="en", desire="d", waiting=0
        )
        system.graph.channel("speech").publish(said)
        assert json.loads(await live.recv())["said"] == "One moment."
        await live.send(json.dumps({"type": "ping", "t": 7.0}))
        assert json.loads(await live.recv())["t"] == 7.0

        refused = is_problem(await phone.post("/visitor/press", json={"button": "next"}), 409, "tour-refused")
        assert refused["detail"] == "That cannot be pressed now."
        is_problem(await phone.post("/visitor/press", json={"button": "end"}), 422, "invalid-request")
        is_problem(await phone.post("/visitor/press", json={}), 422, "invalid-request")
        assert (await phone.post("/visitor/press", json={"button": "start"})).status_code == 204
        while (view := json.loads(await live.recv()))["state"] != "confirming":
            pass
        assert view["sentences"] == {"en": ["Shall I?"], "fr": ["Puis-je ?"]}
        # By a press, or since nobody is seen before the robot: whichever is first.
        await client.post("/tour-run/press", json={"button": "end"})
        await live.wait_closed()
        assert live.close_code == 1008
    is_problem(await phone.post("/visitor/press", json={"button": "start"}), 401, "login-needed")
    is_problem(await enter(phone, key), 401, "wrong-key")
    assert await key_of(client) not in ("", key), "the next visitors have another"
    assert (await client.delete("/tour-run")).status_code == 204
    assert await key_of(client) == ""


async def test_presses_and_windows_of_a_phone_are_bounded(
    client: httpx.AsyncClient, phone: httpx.AsyncClient, url: str, there: None
) -> None:
    await enter(phone, await lead(client))
    answers = [await phone.post("/visitor/press", json={"button": "next"}) for _ in range(PRESSES_AT_ONCE + 3)]
    assert answers[0].status_code == 409
    is_problem(answers[-1], 429, "too-many-requests")
    assert int(answers[-1].headers["retry-after"]) >= 1
    stream = url.replace("http", "ws") + "/api/v1/visitor/live"
    windows = [
        await websockets.connect(stream, proxy=None, additional_headers=cookie(phone)) for _ in range(MOST_OF_ONE)
    ]
    with pytest.raises(websockets.InvalidStatus):
        await websockets.connect(stream, proxy=None, additional_headers=cookie(phone))
    flood = windows[0]
    with contextlib.suppress(websockets.ConnectionClosed):
        for _ in range(100):
            await flood.send("x")
    await flood.wait_closed()
    assert flood.close_code == 1008
    for window in windows[1:]:
        await window.close()


async def test_of_files_only_what_the_tour_shows_is_given(
    client: httpx.AsyncClient, phone: httpx.AsyncClient, system: System, there: None, tmp_path: Path
) -> None:
    folder = system.tours.library.folder

    def place() -> None:
        (folder / "media").mkdir(parents=True, exist_ok=True)
        (folder / "media" / "arm.jpg").write_bytes(PICTURE)
        (folder / "media" / "other.jpg").write_bytes(PICTURE)
        (tmp_path / "secret.jpg").write_bytes(b"secret")
        (folder / "media" / "link.jpg").symlink_to(tmp_path / "secret.jpg")

    await asyncio.to_thread(place)
    linked = {"show": {"file": "media/link.jpg", "alt": {"en": "A link"}}}
    await enter(phone, await lead(client, farewell={"do": [linked]}))
    shown = await phone.get("/visitor/media/media/arm.jpg")
    assert (shown.status_code, shown.content) == (200, PICTURE)
    assert shown.headers["content-type"] == "image/jpeg"
    assert shown.headers["x-content-type-options"] == "nosniff"
    assert "sandbox" in shown.headers["content-security-policy"]
    assert "content-disposition" not in shown.headers
    part = await phone.get("/visitor/media/media/arm.jpg", headers={"Range": "bytes=0-2"})
    assert (part.status_code, part.content) == (206, PICTURE[:3])
    wrong = await phone.get("/visitor/media/media/arm.jpg", headers={"Range": "bytes=99-"})
    is_problem(wrong, 416, "range-not-satisfiable")
    for file in (
        *("media/other.jpg", "media/link.jpg", "new-tour.yaml", "../secret.jpg", "%2e%2e/secret.jpg", ""),
        *("media%2F..%2Fmedia%2Farm.jpg", "media//arm.jpg", "media%2F..%2F..%2Fsecret.jpg", "media/arm.jpg%00"),
    ):
        refused = await phone.get(f"/visitor/media/{file}")
        assert refused.status_code in (401, 404), file
        assert refused.headers["content-type"] == "application/problem+json", file


async def test_the_link_is_for_operators_alone(
    phone: httpx.AsyncClient, client: httpx.AsyncClient, there: None
) -> None:
    assert answered(await client.get("/tour-run/visitors"), VisitorLink).url == "", "no tour, no way in"
    await enter(phone, await lead(client))
    is_problem(await phone.get("/tour-run/visitors", headers=cookie(phone)), 401, "login-needed")


async def test_a_file_that_is_too_large_for_phones_is_refused(
    client: httpx.AsyncClient, phone: httpx.AsyncClient, system: System, there: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def place() -> None:
        (system.tours.library.folder / "media").mkdir(parents=True, exist_ok=True)
        (system.tours.library.folder / "media" / "arm.jpg").write_bytes(PICTURE)

    await asyncio.to_thread(place)
    await enter(phone, await lead(client))
    monkeypatch.setattr(media_content, "LARGEST_PICTURE_BYTES", 4)
    is_problem(await phone.get("/visitor/media/media/arm.jpg"), 409, "media-too-large")


async def test_the_face_shows_the_link_while_a_tour_would_have_visitors(
    client: httpx.AsyncClient, url: str, there: None
) -> None:
    key = await lead(client)
    address = url.replace("http", "ws") + "/api/v1/face"
    async with (
        asyncio.timeout(PATIENCE_S),
        websockets.connect(address, proxy=None, additional_headers=OPERATOR) as screen,
    ):
        while (link := json.loads(await screen.recv()))["type"] != "visitor_link":
            pass
        check("visitor_link", link)
        assert link["url"].endswith(f"/visitor#key={key}")
        assert len(link["code"]) == len(link["code"][0]) >= 21
        assert (await client.delete("/tour-run")).status_code == 204
        while (link := json.loads(await screen.recv()))["type"] != "visitor_link":
            pass
        assert (link["url"], link["code"]) == ("", [])
