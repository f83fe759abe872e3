"""The shapes of what REST tells of a recording that is played and is asked of it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from app.console.rest.models import Answer, Request, Stamp
from app.logs.replay.playback_state import FASTEST, SLOWEST

_SPEED = "Seconds of the recording in a real second; null: as fast as possible, nothing dropped."


class PlaybackModel(Answer):
    """What is played, and where it is."""

    file: str = Field(description="Name of the recording's file.", examples=["tour.mcap"])
    begin: Stamp
    end: Stamp
    position: Stamp
    speed: float | None = Field(description=_SPEED)
    playing: bool = Field(description="Whether time goes on, or will after the seek under way.")
    phase: Literal["playing", "paused", "ended", "seeking"]
    problem: str | None = Field(
        description="What cannot be read of the recording here, in words, why it stands.",
        examples=["0.1 s from 0:07.5 cannot be read"],
    )


class PlaybackChange(Request):
    """What to change; the rest stays."""

    playing: bool | None = None
    speed: float | None = Field(None, ge=SLOWEST, le=FASTEST, description=_SPEED)
    position: float | None = Field(None, description="Go there (stamp of the recording, s).", examples=[1795000012.5])
