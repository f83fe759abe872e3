"""Webhooks over REST, with a receiver that is really called."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI, Request, Response

from app.console.app import create_app
from app.console.webhooks.webhooks import Webhooks
from app.program.system import System
from tests.console.program import served
from tests.logs.replay.logs import lab_log
from tests.logs.replay.playing import prepare
from tests.patience import PATIENCE_S

NEW = {"kinds": ["goal"], "url": "http://127.0.0.1:9/hook"}


class Receiver:
    """A program on this computer that is called; ``status`` is what it answers."""

    def __init__(self) -> None:
        self.status = 204
        self.url = ""
        self.came: asyncio.Queue[tuple[dict[str, str], bytes]] = asyncio.Queue()
        self.app = FastAPI()
        self.app.add_api_route("/hook", self._take, methods=["POST"])

    async def _take(self, request: Request) -> Response:
        self.came.put_nowait((dict(request.headers), await request.body()))
        return Response(status_code=self.status, headers={"location": "/elsewhere"})

    async def next(self) -> tuple[dict[str, str], bytes]:
        async with asyncio.timeout(PATIENCE_S):
            return await self.came.get()


@pytest.fixture
async def receiver() -> AsyncIterator[Receiver]:
    found = Receiver()
    async with served(found.app) as url:
        found.url = f"{url}/hook"
        yield found


@asynccontextmanager
async def console(system: System, page: Path, file: Path | None) -> AsyncIterator[httpx.AsyncClient]:
    app = create_app(system, static_dir=page, early_view=False, webhooks_file=file)
    async with app.router.lifespan_context(app):
        transport = httpx.ASGITransport(app, raise_app_exceptions=True)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080/api/v1") as client:
            yield client


async def until_state(client: httpx.AsyncClient, id_: str, state: str) -> dict[str, Any]:
    async with asyncio.timeout(PATIENCE_S):
        while True:
            report: dict[str, Any] = (await client.get(f"/webhooks/{id_}")).json()
            if report["state"] == state:
                return report
            await asyncio.sleep(0)


async def test_an_event_reaches_the_receiver_signed_and_after_a_restart_too(
    system: System, page: Path, tmp_path: Path, receiver: Receiver
) -> None:
    file = tmp_path / "webhooks.json"
    async with console(system, page, file) as client:
        answer = await client.post("/webhooks", json={**NEW, "url": receiver.url})
        assert answer.status_code == 201, answer.text
        id_, secret = answer.json()["webhook"]["id"], answer.json()["secret"]
        event = system.timeline.add("goal", "GoTo", "there", {"x": 1.5})
        headers, body = await receiver.next()
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        key = base64.b64decode(secret.removeprefix("whsec_"))
        expected = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
        assert headers["webhook-signature"] == f"v1,{expected}"
        assert json.loads(body) == {
            "type": "timeline.goal",
            "timestamp": event.stamp,
            "data": {
                "id": event.id,
                "stamp": event.stamp,
                "kind": "goal",
                "subject": "GoTo",
                "text": "there",
                "data": {"x": 1.5},
            },
        }
        assert (await until_state(client, id_, "idle"))["url"] == receiver.url
        assert "secret" not in (await client.get("/webhooks")).text
    async with console(system, page, file) as client:
        assert [hook["id"] for hook in (await client.get("/webhooks")).json()["webhooks"]] == [id_]
        system.timeline.add("goal", "GoTo", "there again")
        again, _ = await receiver.next()
        assert again["webhook-id"] != headers["webhook-id"]
        assert (await client.delete(f"/webhooks/{id_}")).status_code == 204
        assert (await client.get(f"/webhooks/{id_}")).status_code == 404
    async with console(system, page, file) as client:
        assert (await client.get("/webhooks")).json() == {"webhooks": []}


async def test_a_trial_says_what_became_of_it(client: httpx.AsyncClient, receiver: Receiver) -> None:
    made = (await client.post("/webhooks", json={**NEW, "url": receiver.url})).json()["webhook"]
    trial = f"/webhooks/{made['id']}/trial"
    assert (await client.post(trial)).json() == {"delivered": True, "status": 204, "problem": ""}
    assert json.loads((await receiver.next())[1])["data"]["data"] == {"trial": True}
    receiver.status = 307  # nobody agreed upon what is there
    answer = (await client.post(trial)).json()
    assert answer == {"delivered": False, "status": 307, "problem": "the receiver answered 307"}
    assert (await client.get(f"/webhooks/{made['id']}")).json()["problem"] == "the receiver answered 307"
    nobody = (await client.post("/webhooks", json=NEW)).json()["webhook"]
    answer = (await client.post(f"/webhooks/{nobody['id']}/trial")).json()
    assert (answer["delivered"], answer["status"]) == (False, None)
    assert answer["problem"].startswith("the receiver could not be reached: ")


async def test_a_receiver_that_takes_the_event_and_says_nothing_has_failed(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Webhooks, "answers_within_s", 0.2)

    async def read_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()
        await writer.wait_closed()

    silent = await asyncio.start_server(read_on, "127.0.0.1", 0)
    async with silent:
        url = f"http://127.0.0.1:{silent.sockets[0].getsockname()[1]}/"
        made = (await client.post("/webhooks", json={**NEW, "url": url})).json()["webhook"]
        answer = (await client.post(f"/webhooks/{made['id']}/trial")).json()
        assert answer == {"delivered": False, "status": None, "problem": "the receiver did not answer within 0.2 s"}


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"url": "ftp://example.org/"}, "url", "begins with https:// or http://"),
        ({"kinds": []}, "kinds", "at least 1"),
        ({"kinds": ["weather"]}, "kinds.0", "'desire'"),
        ({"secret": "open sesame"}, "secret", "whsec_"),
        ({"colour": "red"}, "colour", ""),
    ],
)
async def test_what_is_wrong_is_named(
    client: httpx.AsyncClient, change: dict[str, Any], field: str, words: str
) -> None:
    answer = await client.post("/webhooks", json={**NEW, **change})
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert error["field"] == field
    assert words in error["message"]
    assert (await client.get("/webhooks")).json() == {"webhooks": []}


async def test_there_are_twenty_at_most(client: httpx.AsyncClient) -> None:
    for _ in range(20):
        assert (await client.post("/webhooks", json=NEW)).status_code == 201
    answer = await client.post("/webhooks", json=NEW)
    assert (answer.status_code, answer.json()["detail"]) == (409, "There are 20 webhooks: remove one first.")


async def test_a_file_that_cannot_be_read_is_not_overwritten(system: System, page: Path, tmp_path: Path) -> None:
    file = tmp_path / "webhooks.json"
    file.write_text("half a fi")
    async with console(system, page, file) as client:
        answer = await client.post("/webhooks", json=NEW)
        assert answer.status_code == 409
        assert f"{file}" in answer.json()["detail"]
    assert file.read_text() == "half a fi"


async def test_one_that_the_disk_does_not_take_is_none(system: System, page: Path, tmp_path: Path) -> None:
    (tmp_path / ".webhooks.json.new").mkdir()  # in the way of the draft
    async with console(system, page, tmp_path / "webhooks.json") as client:
        answer = await client.post("/webhooks", json=NEW)
        assert (answer.status_code, answer.json()["type"]) == (507, "urn:hbba:problem:not-kept")
        assert (await client.get("/webhooks")).json() == {"webhooks": []}


async def test_unknown_ones_are_not_found(client: httpx.AsyncClient) -> None:
    for method, path in (("GET", ""), ("DELETE", ""), ("POST", "/trial")):
        answer = await client.request(method, f"/webhooks/none{path}")
        assert (answer.status_code, answer.json()["type"]) == (404, "urn:hbba:problem:no-such-webhook")


@pytest.fixture
def prepared() -> Any:
    """A short recording."""
    return prepare(lab_log(1.0))


async def test_a_replay_calls_nobody(replay_url: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{replay_url}/api/v1") as client:
        answer = await client.post("/webhooks", json=NEW)
        assert (answer.status_code, answer.json()["type"]) == (409, "urn:hbba:problem:no-webhooks")
