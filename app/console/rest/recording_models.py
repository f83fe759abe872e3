"""The shapes of what REST tells of recordings and is asked of them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from app.console.recordings import INTENSITY, UTILITY
from app.console.rest.models import Answer, DesireModel, Request, Stamp
from app.logs.library import NAME_PATTERN, name_or_nothing

#: Empty: a name made of the time.
Name = Annotated[str, AfterValidator(name_or_nothing), Field(json_schema_extra={"pattern": NAME_PATTERN})]
LONGEST_RING_MINUTES = 120


class RecorderModel(Answer):
    """What the Recorder does."""

    stamp: Stamp
    state: Literal["idle", "recording", "ring", "stopped"] = Field(
        description="`ring`: the last minutes are kept. `stopped`: by itself, though still desired; see `reason`."
    )
    name: str = Field(description="The recording's; empty while idle.")
    began: float | None = Field(description="When it began (robot's clock).")
    duration_s: float
    bytes: int = Field(description="On disk so far.")
    messages: int
    dropped: int = Field(description="Messages that could not be queued for the disk.")
    queued_bytes: int = Field(description="What waits for the disk now.")
    keep_minutes: float = Field(description="Of the ring; 0: everything goes into one file.")
    desired: bool = Field(description="Whether anybody desires a recording.")
    reason: str = Field(description="Why it does not record though it is desired, in words; empty when all is well.")
    available: bool = Field(description="Whether it runs and attention has a strategy for it.")


class RecordingModel(Answer):
    """One recording."""

    name: str = Field(examples=["tour"])
    bytes: int
    duration_s: float | None = Field(description="From its first message to its last; null where it is not known.")
    began: float | None = Field(description="Its first message (robot's clock); null where it is not known.")
    state: Literal["complete", "recording", "unfinished"] = Field(
        description="`unfinished`: it was never closed; `hbba log repair` makes it readable."
    )
    robot: str = Field(description="The robot's name; empty where the file does not say.")


class ReplayModel(Answer):
    """A replay that runs."""

    name: str = Field(description="The recording replayed.", examples=["tour"])
    url: str = Field(description="Its console's address, with the token behind `#` where there is one.")


class RecordingList(Answer):
    """Every recording, the newest first, and what the Recorder does."""

    folder: str
    free_bytes: int = Field(description="Room left on its disk.")
    recorder: RecorderModel | None = Field(description="null: this program has no Recorder.")
    replay: ReplayModel | None = Field(description="The replay that this console started, while it runs.")
    recordings: list[RecordingModel]


class NewRecording(Request):
    """What to record."""

    name: Name = Field("", description="Empty: the date and time at which it begins.")
    keep_minutes: float = Field(
        0, ge=0, le=LONGEST_RING_MINUTES, description="0: all into one file; else the last so many minutes are kept."
    )
    intensity: float = Field(INTENSITY, gt=0, le=8, description="How much it is desired.")
    utility: float = Field(UTILITY, gt=0, le=8, description="Utility desired: how full the recording must be at least.")


class Withdrawn(Answer):
    """What became of the desires to record."""

    withdrawn: list[str] = Field(description="Ids of the desires withdrawn.")
    remaining: list[DesireModel] = Field(description="Those of motivations, which go on.")


class SaveRequest(Request):
    """What of the ring to keep."""

    minutes: float | None = Field(
        None, gt=0, le=LONGEST_RING_MINUTES, description="The last so many; null: all there are."
    )
    name: Name = Field("", description="Empty: a name made of the time.")


class Saved(Answer):
    """The recording made of the ring."""

    name: str
