"""What the robot remembers of what it experienced."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from msgspec import Struct

from app.messages.base import Stamp, doc

MemoryChannel = Literal["person", "object", "place", "emotion", "desire"]


@dataclass(frozen=True, slots=True)
class MemoryItem:
    """Something that belongs to an event."""

    channel: MemoryChannel
    item: Annotated[
        str,
        doc(
            "Which: `someone`, or `person 3` by the number of this run of the program; `code lab` by the place in "
            "front of which it hangs, else by a number; `word hello`; a place's id on its map; the class of a desire."
        ),
    ]
    weight: Annotated[float, doc("How firmly it belongs to it, over 0 and at most 1.")]


@dataclass(frozen=True, slots=True)
class MemoryEvent:
    """What was perceived and done at one time."""

    id: int
    items: tuple[MemoryItem, ...]


@dataclass(frozen=True, slots=True)
class AnticipatedEvent:
    """An event that is to come, by the episode that is recognized."""

    event: MemoryEvent
    weight: Annotated[float, doc("In the episode, over 0 and at most 1: the later, the greater.")]


@dataclass(frozen=True, slots=True)
class EpisodeSummary:
    """An episode in a few words."""

    id: int
    times: Annotated[int, doc("How often it has happened.")]
    first: Annotated[float, doc("When it ended first (robot's clock, s).")]
    last: Annotated[float, doc("When it ended last (robot's clock, s).")]
    events: Annotated[int, doc("How many it has.")]
    items: Annotated[tuple[MemoryItem, ...], doc("The firmest of its events, at most 8.")]
    deeds: Annotated[tuple[str, ...], doc("Classes of desires that led to its accomplishment.")]


class RaisedDesire(Struct, frozen=True, rename={"cls": "class"}):
    """A desire of memory's."""

    id: Annotated[str, doc("Of the desire.")]
    cls: str
    intensity: float
    episode: Annotated[int, doc("The episode that is the reason.")]
    why: Annotated[str, doc("In words.")]


@dataclass(frozen=True, slots=True)
class MemoryState:
    """What happens now, as memory sees it, and the episodes it has; published with each change."""

    stamp: Stamp
    on: Annotated[bool, doc("Whether anything is remembered.")]
    problem: Annotated[str, doc("Why nothing is written to the disk, in words; empty: nothing is wrong.")]
    under_way: Annotated[
        tuple[MemoryEvent, ...], doc("The last events of the episode under way, at most 12, in order.")
    ]
    recognized: Annotated[int | None, doc("The episode that this is like; null: none.")]
    match: Annotated[float, doc("How much it is like it, 0 to 1.")]
    anticipated: Annotated[tuple[AnticipatedEvent, ...], doc("What comes next by that, the next first, at most 5.")]
    raised: tuple[RaisedDesire, ...]
    episodes: Annotated[tuple[EpisodeSummary, ...], doc("At most 20, those that happened last first.")]
    episode_count: int
    event_count: int


@dataclass(frozen=True, slots=True)
class EpisodeEvent:
    """An event of an episode, in its order."""

    event: int
    weight: Annotated[float, doc("Over 0 and at most 1: the later, the greater.")]


class EpisodeDeed(Struct, frozen=True, rename={"cls": "class"}):
    """A desire that led to the accomplishment of an episode."""

    cls: str
    params: Mapping[str, Any]
    weight: Annotated[float, doc("In which share of the last times, over 0 and at most 1.")]


@dataclass(frozen=True, slots=True)
class EpisodeReport:
    """An episode as it is kept."""

    id: int
    times: int
    first: Annotated[float, doc("When it ended first (robot's clock, s).")]
    last: Annotated[float, doc("When it ended last (robot's clock, s).")]
    learning_rate: Annotated[float, doc("How fast it is overwritten, 0.1 to 1.")]
    vigilance: Annotated[float, doc("The match from which it is recognized, 0.45 to 0.85.")]
    events: tuple[EpisodeEvent, ...]
    deeds: tuple[EpisodeDeed, ...]


@dataclass(frozen=True, slots=True)
class MemoryReport:
    """All that is remembered."""

    stamp: Stamp
    episodes: Annotated[tuple[EpisodeReport, ...], doc("Those that happened last first.")]
    events: tuple[MemoryEvent, ...]
