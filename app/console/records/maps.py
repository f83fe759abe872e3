"""Maps, the one in use, and its zones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from app.messages.base import doc

LocalizationState = Literal["mapping", "tracking", "searching", "lost"]
ZoneKind = Literal["keep_out", "slow"]


@dataclass(frozen=True, slots=True)
class CurrentMap:
    """The map in use."""

    available: Annotated[bool, doc("Whether this program makes maps; if not, nothing of this can be asked.")]
    name: Annotated[str, doc("Empty while it has none.")]
    state: Annotated[
        LocalizationState | None,
        doc("Of the robot's place on it, as on the live stream; null before it is known."),
    ]
    stamp: Annotated[float | None, doc("When that was so (robot's clock, s).")]


@dataclass(frozen=True, slots=True)
class KeptMap:
    """A map that is kept."""

    name: Annotated[str, Meta(examples=["ground-floor"])]
    in_use: bool
    saved: Annotated[float, doc("Unix time (s).")]
    size_m: Annotated[tuple[float, float], doc("Width and height of its picture.")]
    resolution_m: Annotated[float, doc("Of one cell, and of one pixel.")]
    known_m2: Annotated[float, doc("How much floor and wall of it is known.")]
    extendable: Annotated[bool, doc("Whether it can go on growing when it is loaded.")]
    zones: Annotated[int, doc("How many it has.")]
    problem: Annotated[str | None, doc("Why it cannot be used, in words.")]


@dataclass(frozen=True, slots=True)
class MapList:
    """Every map that is kept, by name, and the one in use."""

    folder: str
    current: CurrentMap
    maps: tuple[KeptMap, ...]


@dataclass(frozen=True, slots=True)
class ZoneReport:
    """A part of the map to keep out of, or to drive slowly in."""

    name: Annotated[str, doc("What people call it; no two share one.")]
    kind: ZoneKind
    polygon: Annotated[tuple[tuple[float, float], ...], doc("Its corners, x and y on the map (m).")]
    speed: Annotated[float, doc("Share of the robot's greatest speed allowed in it; means nothing to `keep_out`.")]


@dataclass(frozen=True, slots=True)
class ZoneList:
    """Every zone of the map."""

    zones: tuple[ZoneReport, ...]
