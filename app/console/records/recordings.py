"""Recordings, the Recorder, and the transport of a replay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from app.attention.desires import Desire
from app.logs.replay.playback_state import Phase
from app.messages import RecorderState
from app.messages.base import Stamp, doc


@dataclass(frozen=True, slots=True)
class RecorderReport:
    """State of the Recorder."""

    stamp: Stamp
    state: Annotated[
        RecorderState,
        doc("`ring`: the last minutes are kept. `stopped`: by itself, though still desired; see `reason`."),
    ]
    name: Annotated[str, doc("The recording's; empty while idle.")]
    began: Annotated[float | None, doc("When it began (robot's clock, s).")]
    duration_s: float
    bytes: Annotated[int, doc("On disk so far.")]
    messages: int
    dropped: Annotated[int, doc("Messages that could not be queued for the disk.")]
    queued_bytes: Annotated[int, doc("What waits for the disk now.")]
    keep_minutes: Annotated[float, doc("Of the ring; 0: everything goes into one file.")]
    desired: Annotated[bool, doc("Whether there is a desire for a recording.")]
    reason: Annotated[str, doc("Why it does not record though it is desired, in words; empty when all is well.")]
    available: Annotated[bool, doc("Whether it runs and attention has a strategy for it.")]


@dataclass(frozen=True, slots=True)
class RecordingReport:
    """One recording."""

    name: Annotated[str, Meta(examples=["tour"])]
    bytes: int
    duration_s: Annotated[float | None, doc("From its first message to its last; null where it is not known.")]
    began: Annotated[float | None, doc("Its first message (robot's clock, s); null where it is not known.")]
    state: Annotated[
        Literal["complete", "recording", "unfinished"],
        doc("`unfinished`: it was never closed; `hbba log repair` makes it readable."),
    ]
    robot: Annotated[str, doc("The robot's name; empty where the file does not say.")]


@dataclass(frozen=True, slots=True)
class ReplayReport:
    """A replay that runs."""

    name: Annotated[str, Meta(description="The recording replayed.", examples=["tour"])]
    url: Annotated[str, doc("Its console's address, with the token behind `#` where there is one.")]


@dataclass(frozen=True, slots=True)
class RecordingList:
    """Every recording, the newest first, and what the Recorder does."""

    folder: str
    free_bytes: Annotated[int, doc("Room left on its disk.")]
    recorder: Annotated[RecorderReport | None, doc("null: this program has no Recorder.")]
    replay: Annotated[ReplayReport | None, doc("The replay that this console started, while it runs.")]
    recordings: tuple[RecordingReport, ...]


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """Desires to record that were withdrawn, and those that remain."""

    withdrawn: Annotated[tuple[str, ...], doc("Ids of the desires withdrawn.")]
    remaining: Annotated[tuple[Desire, ...], doc("Those of motivations, which go on.")]


@dataclass(frozen=True, slots=True)
class Saved:
    """The recording made of the ring."""

    name: str


@dataclass(frozen=True, slots=True)
class PlaybackReport:
    """State of the playback; stamps are the recording's."""

    file: Annotated[str, Meta(description="Name of the recording's file.", examples=["tour.mcap"])]
    begin: Stamp
    end: Stamp
    position: Stamp
    speed: Annotated[
        float | None, doc("Seconds of the recording in a real second; null: as fast as possible, nothing dropped.")
    ]
    playing: Annotated[bool, doc("Whether time goes on, or will after the seek under way.")]
    phase: Phase
    problem: Annotated[
        str | None,
        Meta(
            description="Why it cannot go on: the part of the recording that cannot be read.",
            examples=["0.1 s from 0:07.5 cannot be read"],
        ),
    ]
