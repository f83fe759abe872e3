"""The past of the lanes, brought down to what a page can show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta, Struct

from app.messages import Divisor, LaneState
from app.messages.base import doc


class LaneChange(Struct, frozen=True):
    """What a lane was, from ``stamp`` until the next change."""

    stamp: Annotated[float, doc("Robot's clock (s).")]
    intensity: float | None
    utility: float | None
    divisor: Divisor
    divisors: Annotated[Mapping[str, Divisor], doc("By filter, `Module.port`.")]
    state: LaneState
    text: str


class LaneBuckets(Struct, frozen=True, rename={"cls": "class"}):
    """A lane before now; of each bucket the rate's last value, its least and its greatest (null: there was none)."""

    cls: str
    rate: Annotated[tuple[float | None, ...], doc("The last of each bucket.")]
    low: Annotated[tuple[float | None, ...], doc("Empty where every sample is a bucket.")]
    high: Annotated[tuple[float | None, ...], doc("Empty where every sample is a bucket.")]
    changes: Annotated[
        tuple[LaneChange, ...],
        doc("Oldest first; of more than two in a bucket the most closed and the last. The first holds from the start."),
    ]


@dataclass(frozen=True, slots=True)
class LanesPast:
    """What the lanes were in a stretch of time. Stamps are of the robot's clock (s)."""

    oldest: Annotated[float | None, doc("Stamp of the oldest sample that is kept; null: there is none.")]
    bucket_s: Annotated[float, Meta(ge=0), doc("Width of a bucket; 0: every sample is one.")]
    stamps: Annotated[tuple[float, ...], doc("Of the first sample of each bucket.")]
    ends: Annotated[tuple[float, ...], doc("Of its last.")]
    rows: tuple[LaneBuckets, ...]
