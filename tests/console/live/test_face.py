"""The stream of the face: nine joints and what is said, to pages that are no viewers."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from typing import Any

import httpx
import jsonschema
import pytest
import websockets
from fastapi import FastAPI
from websockets.asyncio.client import ClientConnection

from app.console.app import create_app
from app.console.live.hub import Hub
from app.messages import JointState, Speech
from app.modules.behaviors.face.expression import JOINTS
from app.program.system import System
from tests.console.live.test_asyncapi import check
from tests.console.program import Body, served, write_page
from tests.patience import PATIENCE_S


@contextlib.asynccontextmanager
async def looking(url: str) -> AsyncIterator[ClientConnection]:
    async with (
        asyncio.timeout(PATIENCE_S),
        websockets.connect(f"{url.replace('http', 'ws')}/api/v1/face", open_timeout=None) as connection,
    ):
        yield connection


async def received(connection: ClientConnection, kind: str) -> dict[str, Any]:
    while (message := json.loads(await connection.recv()))["type"] != kind:
        pass
    check(kind, message)
    return dict(message)


def joints(system: System, lips: float) -> JointState:
    names = ("pan_joint", *JOINTS)
    return JointState(system.clock.now(), names, tuple(lips if "lip" in name else 0.5 for name in names))


def said(system: System, text: str) -> Speech:
    return Speech(system.clock.now(), "speaking", text, 0, 2, viseme="open", language="en", desire="d", waiting=0)


async def test_a_face_gets_its_nine_joints_and_what_is_said_and_is_no_viewer(
    url: str, system: System, body: Body, hub: Hub
) -> None:
    system.graph.channel("speech").publish(said(system, "Before."))
    async with looking(url) as screen:
        assert (await received(screen, "speech"))["text"] == "Before.", "what stands comes at once"
        sent = joints(system, 0.12346)
        body.emit("joints", sent)
        face = await received(screen, "face")
        assert set(face["joints"]) == set(JOINTS), "not those of the head"
        assert face["joints"]["lower_lip_joint"] == 0.1235
        assert face["stamp"] == pytest.approx(sent.stamp)
        system.graph.channel("speech").publish(said(system, "Hello."))
        assert (await received(screen, "speech"))["text"] == "Hello."
        await screen.send("nonsense")
        await screen.send(json.dumps({"type": "ping", "t": 7.0}))
        assert (await received(screen, "pong"))["t"] == 7.0
        await screen.send(json.dumps({"type": "e_stop"}))
        assert body.stops == [], "it shows, and does nothing"
        assert hub.viewers == ()
        assert not [desire for desire in system.workspace.desires() if desire.cls == "Telepresence"]
        assert system.graph.channel("speech").wanted
        rests = asyncio.Event()
        system.graph.channel("speech").on_wanted(lambda wanted: None if wanted else rests.set())
    await asyncio.wait_for(rests.wait(), PATIENCE_S)


async def test_the_newest_face_is_sent_to_a_screen_that_comes_later(url: str, system: System, body: Body) -> None:
    async with looking(url) as first:
        body.emit("joints", joints(system, 0.2))
        await received(first, "face")
        async with looking(url) as second:
            assert (await received(second, "face"))["joints"]["upper_lip_joint"] == 0.2


async def test_its_page_has_a_short_address_and_its_stream_needs_the_token(system: System, tmp_path: Any) -> None:
    static = await asyncio.to_thread(write_page, tmp_path)
    (static / "face.html").write_text("<!doctype html><title>face</title>")
    app: FastAPI = create_app(system, static_dir=static, early_view=False, token="a long token")
    async with served(app) as url:
        async with httpx.AsyncClient(base_url=url, timeout=PATIENCE_S) as rest:
            for address in ("/face", "/face.html"):
                page = await rest.get(address)
                assert "<title>face</title>" in page.text
                assert "default-src 'self'" in page.headers["content-security-policy"]
        with pytest.raises(websockets.InvalidStatus) as refused:
            async with looking(url):
                pass
        assert refused.value.response.status_code == 401


def test_a_message_that_is_no_face_is_not_as_described() -> None:
    with pytest.raises(jsonschema.ValidationError):
        check("face", {"type": "face", "stamp": 1.0, "joints": [1.0]})
