"""The recorder and the recordings that the mock console pretends to have; see mock_server.py."""

from __future__ import annotations

import asyncio
import time
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, Response
from mock_robot import Mock, problem

DAY_S = 86_400


class MockRecorder:
    """Records nothing, at two megabytes a second. Modes: ``recorder_stopped`` and ``recorder_refused`` (a reason),
    ``recordings_broken``, ``replay_url``."""

    def __init__(self, mock: Mock) -> None:
        self.mock = mock
        self.state, self.name, self.began, self.keep, self.reason = "idle", "", 0.0, 0.0, ""
        self.replay: dict[str, str] | None = None
        now = time.time()
        self.files = [
            _file("tour-of-the-lab", now - 2 * 3600, 312.4, 652_100_000),
            _file("20261119-163012", now - 2 * DAY_S, 61.0, 118_300_000, "unfinished"),
            _file("corridor.hokuyo-only", now - 5 * DAY_S, 1_812.9, 44_020_000),
            _file("bag-of-another-robot", now - 400 * DAY_S, 20.2, 9_100_000, robot="TurtleBot 2"),
        ]

    def status(self) -> dict[str, Any]:
        busy = self.state in ("recording", "ring")
        seconds = time.time() - self.began if busy else 0.0
        if self.state == "ring":
            seconds = min(seconds, self.keep * 60)
        return {
            "type": "recorder",
            "stamp": time.time(),
            "state": "stopped" if self.mock.mode.get("recorder_stopped") else self.state,
            "name": self.name,
            "began": self.began or None,
            "duration_s": seconds,
            "bytes": int(seconds * 2_090_000),
            "messages": int(seconds * 431),
            "dropped": self.mock.mode.get("recorder_dropped", 0),
            "queued_bytes": 0,
            "keep_minutes": self.keep,
            "desired": busy or bool(self.mock.mode.get("recorder_refused")),
            "reason": self.mock.mode.get("recorder_stopped") or self.mock.mode.get("recorder_refused") or "",
            "available": not self.mock.mode.get("no_recorder"),
        }

    def tell(self) -> None:
        self.mock.tell(self.status())

    async def begin(self, name: str, keep: float) -> None:
        await asyncio.sleep(0.6)
        self.state, self.keep = ("ring" if keep else "recording"), keep
        self.name, self.began = name or time.strftime("%Y%m%d-%H%M%S"), time.time()
        self.tell()

    async def end(self) -> None:
        await asyncio.sleep(0.3)
        status = self.status()
        if self.state == "recording":
            self.files.append(_file(self.name, self.began, status["duration_s"], status["bytes"]))
        self.state, self.name, self.began = "idle", "", 0.0
        self.tell()

    def listing(self) -> list[dict[str, Any]]:
        if self.mock.mode.get("empty"):
            return []
        status = self.status()
        written = (
            [_file(self.name, self.began, status["duration_s"], status["bytes"], "recording")] if self.name else []
        )
        return [*self.files, *written]


def _file(name: str, began: float, seconds: float, size: int, state: str = "complete", robot: str = "IRL-1/TR") -> Any:
    return {"name": name, "bytes": size, "duration_s": seconds, "began": began, "state": state, "robot": robot}


def recordings_router(mock: Mock, recorder: MockRecorder) -> APIRouter:
    router = APIRouter(prefix="/api/v1/recordings")
    tasks: set[asyncio.Task[None]] = set()

    def later(work: Any) -> None:
        task = asyncio.create_task(work)
        tasks.add(task)
        task.add_done_callback(tasks.discard)

    @router.get("")
    async def listing() -> Response:
        if mock.mode.get("recordings_broken"):
            return problem(500, "The folder cannot be read", "Permission denied: /var/lib/hbba/recordings.")
        body = {
            "folder": "/home/ann/.local/share/hbba/recordings",
            "free_bytes": 212_400_000_000,
            "recorder": recorder.status(),
            "replay": recorder.replay,
            "recordings": recorder.listing(),
        }
        return JSONResponse(body)

    @router.post("")
    async def record(request: Request) -> Response:
        body = await request.json()
        if any(file["name"] == body.get("name") for file in recorder.files):
            return problem(409, "Recording exists", f"There is a recording called {body['name']} already.")
        later(recorder.begin(body.get("name", ""), body.get("keep_minutes", 0)))
        return JSONResponse({"id": "d0", "class": "Record"}, 201)

    @router.post("/stop")
    async def stop() -> Response:
        later(recorder.end())
        return JSONResponse({"withdrawn": ["d0"], "remaining": []})

    @router.post("/save")
    async def save(request: Request) -> Response:
        await asyncio.sleep(0.8)
        status = recorder.status()
        name = (await request.json()).get("name") or time.strftime("%Y%m%d-%H%M%S-ring")
        recorder.files.append(_file(name, time.time() - status["duration_s"], status["duration_s"], status["bytes"]))
        return JSONResponse({"name": name}, 201)

    @router.get("/{name}")
    async def download(name: str) -> Response:
        headers = {"Content-Disposition": f'attachment; filename="{name}.mcap"'}
        return Response(b"\x89MCAP0\r\n", media_type="application/octet-stream", headers=headers)

    @router.delete("/{name}")
    async def delete(name: str) -> Response:
        await asyncio.sleep(0.2)
        recorder.files = [file for file in recorder.files if file["name"] != name]
        return Response(status_code=204)

    @router.post("/{name}/replay")
    async def replay(name: str) -> Response:
        await asyncio.sleep(2.5)
        if url := mock.mode.get("replay_url"):
            recorder.replay = {"name": name, "url": url}
            return JSONResponse(recorder.replay, 201)
        return problem(502, "Replay failed", f"{name} cannot be replayed: it holds no configuration.")

    @router.delete("/{name}/replay")
    async def end_replay(name: str) -> Response:
        recorder.replay = None
        return Response(status_code=204)

    return router
