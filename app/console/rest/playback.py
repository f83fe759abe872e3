"""The transport of a recording: where it is, play and pause, speed, seek, step."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import Response

from app.console.playback import playback_report
from app.console.problems import Problem
from app.console.records.recordings import PlaybackReport
from app.console.rest.answers import Json, problems
from app.console.rest.playback_models import PlaybackChange
from app.console.rest.routing import router as api_router
from app.logs.log import LogError

if TYPE_CHECKING:
    from app.logs.replay.playback import Playback


def playback_router(playback: Playback | None) -> APIRouter:
    """Routes of ``/playback``; 404 where no recording is played (None)."""
    router = api_router("playback")

    def played() -> Playback:
        if playback is None:
            raise Problem(404, "not-a-replay", "This is no recording: there is nothing to play, pause or seek.")
        return playback

    @router.get("/playback", response_model=PlaybackReport, summary="State of the playback", responses=problems(404))
    async def get_playback() -> Response:
        return Json(playback_report(played()))

    @router.patch(
        "/playback",
        response_model=PlaybackReport,
        summary="Play, pause, seek, change the speed",
        responses=problems(400, 404, 409, 422),
    )
    async def change_playback(change: PlaybackChange) -> Response:
        """Members left out stay. Answers once it is so: after a seek, when the scene there is shown. Of several seeks
        at once only the newest is gone to, and all are answered then. A position beyond an end is that end; to play
        from the end is to begin again."""
        player = played()
        named = change.model_fields_set
        if change.playing is False:
            player.pause()
        if "speed" in named:
            player.set_speed(change.speed)
        if change.position is not None:
            await _read(player.seek(change.position))
        if change.playing:
            player.play()
        return Json(playback_report(player))

    @router.post(
        "/playback/step",
        response_model=PlaybackReport,
        summary="Step to the next image",
        responses=problems(404, 409),
    )
    async def step_playback() -> Response:
        """To the next image of the first camera; in a recording without images to the next scan, without scans by
        0.1 s. Answers once the modules have done with it."""
        player = played()
        await _read(player.step())
        return Json(playback_report(player))

    return router


async def _read(doing: Coroutine[object, object, None]) -> None:
    try:
        await doing
    except LogError as failure:
        raise Problem(409, "unreadable-recording", str(failure)) from None
