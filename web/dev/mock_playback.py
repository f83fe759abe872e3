"""A replay's transport, pretended by the mock console; see mock_server.py."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, Response
from mock_robot import problem

LENGTH_S = 187.4
#: What "as fast as possible" reaches here.
FASTEST = 23.0


class MockPlayback:
    """A recording of three minutes; ``now`` is its time."""

    def __init__(self, tell: Callable[[dict[str, Any]], None], slow: float | None = None) -> None:
        self.tell, self.slow = tell, slow
        self.begin = time.time() - 30 * 86_400
        self.end = self.begin + LENGTH_S
        self.speed: float | None = 1.0
        self.playing, self.phase = True, "playing"
        self._base, self._mark = self.begin, time.monotonic()

    def now(self) -> float:
        rate = (FASTEST if self.speed is None else min(self.speed, self.slow or self.speed)) if self.playing else 0.0
        return min(self.end, self._base + (time.monotonic() - self._mark) * rate)

    def set(self, **change: Any) -> None:
        """``position``, ``speed``, ``playing``, ``phase``."""
        self._base, self._mark = change.pop("position", self.now()), time.monotonic()
        for name, value in change.items():
            setattr(self, name, value)
        if self.phase != "seeking":
            self.phase = "playing" if self.playing else "ended" if self.now() >= self.end else "paused"
        self.tell(self.json())

    def json(self) -> dict[str, Any]:
        return {
            "type": "playback",
            "file": "tour-of-the-lab.mcap",
            "begin": self.begin,
            "end": self.end,
            "position": self.now(),
            "speed": self.speed,
            "playing": self.playing,
            "phase": self.phase,
        }

    def beat(self) -> None:
        """Ten times a second."""
        if self.playing and self.now() >= self.end:
            self.set(playing=False)
        elif self.playing:
            self.tell(self.json())

    async def seek(self, position: float) -> None:
        position = max(self.begin, min(self.end, position))
        self.set(phase="seeking")
        await asyncio.sleep(0.15)
        self.tell({"type": "jump", "stamp": position})
        self.set(position=position, phase="playing")


def playback_router(playback: MockPlayback | None) -> APIRouter:
    router = APIRouter(prefix="/api/v1/playback")

    @router.get("")
    async def state() -> Response:
        return JSONResponse(playback.json()) if playback else problem(404, "Not a replay", "This is a living robot.")

    @router.patch("")
    async def change(request: Request) -> Response:
        if not playback:
            return problem(404, "Not a replay", "This is a living robot.")
        body = await request.json()
        if "position" in body:
            await playback.seek(body.pop("position"))
        if body:
            playback.set(**body)
        return JSONResponse(playback.json())

    @router.post("/step")
    async def step() -> Response:
        if not playback:
            return problem(404, "Not a replay", "This is a living robot.")
        playback.set(position=min(playback.end, playback.now() + 1 / 15), playing=False)
        return JSONResponse(playback.json())

    return router
