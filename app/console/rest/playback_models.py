"""Requests about the playback of a recording, checked as it comes in."""

from __future__ import annotations

from pydantic import Field

from app.console.rest.models import Request
from app.logs.replay.playback_state import FASTEST, SLOWEST

_SPEED = "Seconds of the recording in a real second; null: as fast as possible, nothing dropped."


class PlaybackChange(Request):
    """A change of the playback; members left out stay."""

    playing: bool | None = None
    speed: float | None = Field(None, ge=SLOWEST, le=FASTEST, description=_SPEED)
    position: float | None = Field(None, description="Go there (stamp of the recording, s).", examples=[1795000012.5])
