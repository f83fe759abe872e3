"""Requests about recordings, checked as it comes in."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from app.console.recordings import INTENSITY, UTILITY
from app.console.rest.models import Request
from app.logs.library import NAME_PATTERN, name_or_nothing

#: Empty: a name made of the time.
Name = Annotated[str, AfterValidator(name_or_nothing), Field(json_schema_extra={"pattern": NAME_PATTERN})]
LONGEST_RING_MINUTES = 120


class NewRecording(Request):
    """A recording to make."""

    name: Name = Field("", description="Empty: the date and time at which it begins.")
    keep_minutes: float = Field(
        0, ge=0, le=LONGEST_RING_MINUTES, description="0: all into one file; else the last so many minutes are kept."
    )
    intensity: float = Field(INTENSITY, gt=0, le=8, description="How much it is desired.")
    utility: float = Field(UTILITY, gt=0, le=8, description="Utility desired: how full the recording must be at least.")


class SaveRequest(Request):
    """The part of the ring to keep."""

    minutes: float | None = Field(
        None, gt=0, le=LONGEST_RING_MINUTES, description="The last so many; null: all there are."
    )
    name: Name = Field("", description="Empty: a name made of the time.")
