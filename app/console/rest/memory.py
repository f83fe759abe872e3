"""What the robot remembers: read, exported, deleted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Path
from fastapi.responses import Response

from app.console.problems import Problem
from app.console.rest.answers import Json, problems
from app.console.rest.routing import router as api_router
from app.memory.service import MemoryOff, MemoryRefused, MemoryServer, UnknownEpisode
from app.messages import MemoryReport

if TYPE_CHECKING:
    from app.program.system import System

EpisodeId = Annotated[int, Path(ge=1, le=2**53, description="The episode's number.")]


def memory_router(system: System) -> APIRouter:
    """Routes of ``/memory``."""
    router = api_router("memory")

    @router.get("/memory", response_model=MemoryReport, summary="Export what is remembered", responses=problems(409))
    async def get_memory() -> Response:
        """All episodes, those that happened last first, and their events. Of people, it has numbers alone. Refused
        where memory is off."""
        return Json(await _server().report())

    @router.delete("/memory", status_code=204, summary="Delete all that is remembered", responses=problems(409))
    async def delete_memory() -> Response:
        """Also what is under way. What is deleted is overwritten on the disk."""
        server = _server()
        try:
            await server.forget_all()
        except MemoryRefused as refusal:
            raise _problem("disk-refuses", refusal) from None
        return Response(status_code=204)

    @router.delete(
        "/memory/episodes/{episode}", status_code=204, summary="Delete an episode", responses=problems(404, 409, 422)
    )
    async def delete_episode(episode: EpisodeId) -> Response:
        """With the events that were its own."""
        server = _server()
        try:
            await server.forget(episode)
        except UnknownEpisode as refusal:
            raise Problem(404, "no-such-episode", f"{_capital(refusal)}.") from None
        except MemoryRefused as refusal:
            raise _problem("disk-refuses", refusal) from None
        return Response(status_code=204)

    def _server() -> MemoryServer:
        try:
            return system.memory.server
        except MemoryOff as refusal:
            raise _problem("memory-off", refusal) from None

    return router


def _problem(kind: str, refusal: Exception) -> Problem:
    return Problem(409, kind, f"{_capital(refusal)}.")


def _capital(refusal: Exception) -> str:
    words = str(refusal)
    return words[:1].upper() + words[1:]
