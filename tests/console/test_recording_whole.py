"""The whole way over REST: the lab's program records with its own Recorder, and `hbba replay` plays that."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import httpx
import pytest
from fastapi import FastAPI

from app.base import paths
from app.base.geometry import Pose2
from app.console.app import create_app
from app.logs.library import RecordingLibrary
from app.logs.mcap.reader import McapLog
from app.messages import Odometry
from app.program.config import load_configuration
from app.program.system import System
from tests.console.program import Body, image
from tests.patience import PATIENCE_S

TOKEN = "correct horse"


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """The lab's program on a body that the test feeds."""
    body = Body()
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    return System(configuration, link=body, recordings=RecordingLibrary(tmp_path / "recordings")), body


@pytest.fixture
def app(system: System, page: Path) -> FastAPI:
    """Its console, behind a token."""
    return create_app(system, static_dir=page, token=TOKEN, early_view=False)


async def live(system: System, body: Body, rounds: int) -> None:
    """The body senses so many times, 20 times a second."""
    for _ in range(rounds):
        now = system.clock.now()
        body.emit("odometry", Odometry(now, Pose2(0.0, 0.0, 0.0), 0.1, 0.0))
        body.emit("kinect", image(now))
        body.emit_status(now)
        await system.clock.sleep(0.05)


async def until(client: httpx.AsyncClient, state: str) -> dict[str, Any]:
    """The first recording, once it is in ``state``."""
    while True:
        recordings = (await client.get("/recordings")).json()["recordings"]
        if recordings and recordings[0]["state"] == state:
            found: dict[str, Any] = recordings[0]
            return found
        await asyncio.sleep(0.05)


@pytest.mark.slow
async def test_what_is_recorded_over_rest_is_replayed_over_rest(url: str, system: System, body: Body) -> None:
    login = {"Authorization": f"Bearer {TOKEN}"}
    async with (
        asyncio.timeout(PATIENCE_S),
        httpx.AsyncClient(base_url=f"{url}/api/v1", headers=login, timeout=PATIENCE_S) as client,
    ):
        assert (await client.post("/recordings", json={"name": "tour"})).status_code == 201
        await live(system, body, 10)
        await until(client, "recording")
        await live(system, body, 30)
        await client.post("/recordings/stop")
        entry = await until(client, "complete")
        assert entry["name"] == "tour"
        assert entry["robot"] == "a test body"
        assert entry["duration_s"] > 0.5

        download = await client.get("/recordings/tour")
        copy = system.recordings.folder.parent / "copy.mcap"
        await asyncio.to_thread(copy.write_bytes, download.content)
        log = await asyncio.to_thread(McapLog, copy)
        info = log.info
        await asyncio.to_thread(log.close)
        assert info.channels["odometry"].count >= 20
        assert info.channels["kinect"].count >= 5
        assert info.end - info.begin == pytest.approx(entry["duration_s"], abs=1e-3)

        started = await client.post("/recordings/tour/replay")
        assert started.status_code == 201, started.text
        address, _, token = started.json()["url"].partition("/#token=")
        assert unquote(token) == TOKEN
        playback = await client.get(f"{address}/api/v1/playback")
        assert playback.json()["file"] == "tour.mcap"
        assert (await client.get(f"{address}/api/v1/playback", headers={"Authorization": ""})).status_code == 401
        assert (await client.delete("/recordings/tour/replay")).status_code == 204
        with pytest.raises(httpx.TransportError):
            await client.get(f"{address}/api/v1/health")
