"""Messages on what is remembered. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, cast, get_args

from app.memory.em_art import Episode, Event
from app.memory.memory import Memory
from app.messages import (
    EpisodeDeed,
    EpisodeEvent,
    EpisodeReport,
    EpisodeSummary,
    MemoryChannel,
    MemoryEvent,
    MemoryItem,
    MemoryReport,
)

#: At most so many are on the channel; REST has all.
MOST_EPISODES: Final = 20
MOST_UNDER_WAY: Final = 12
MOST_ANTICIPATED: Final = 5
_MOST_ITEMS: Final = 8
_CHANNELS: Final = get_args(MemoryChannel)


def event_message(event: Event) -> MemoryEvent:
    """An event, its items by channel, the firmest first."""
    items = [
        MemoryItem(cast(MemoryChannel, channel), item, round(weight, 3))
        for channel in _CHANNELS
        for item, weight in sorted(event.weights.get(channel, {}).items(), key=lambda each: (-each[1], each[0]))
    ]
    return MemoryEvent(event.id, tuple(items))


def summaries(memory: Memory) -> tuple[EpisodeSummary, ...]:
    """The episodes that happened last, the last first."""
    newest = sorted(memory.art.episodes.values(), key=lambda each: (-each.last, -each.id))[:MOST_EPISODES]
    return tuple(_summary(memory, episode) for episode in newest)


def report(memory: Memory, now: float) -> MemoryReport:
    """All that is remembered, but for events of the episode under way."""
    episodes = sorted(memory.art.episodes.values(), key=lambda each: (-each.last, -each.id))
    used = {event for episode in episodes for event in episode.weights}
    return MemoryReport(
        now,
        tuple(_report(memory, episode) for episode in episodes),
        tuple(event_message(memory.art.events[event]) for event in sorted(used)),
    )


def _summary(memory: Memory, episode: Episode) -> EpisodeSummary:
    firmest: dict[tuple[str, str], float] = {}
    for event in _in_order(episode):
        for channel, items in memory.art.events[event].weights.items():
            for item, weight in items.items():
                key = (channel, item)
                firmest[key] = max(firmest.get(key, 0.0), weight * episode.weights[event])
    chosen = sorted(firmest, key=lambda key: -firmest[key])[:_MOST_ITEMS]
    chosen.sort(key=lambda key: (_CHANNELS.index(key[0]), key[1]))
    return EpisodeSummary(
        id=episode.id,
        times=episode.times,
        first=episode.first,
        last=episode.last,
        events=len(episode.weights),
        items=tuple(MemoryItem(cast(MemoryChannel, c), i, round(firmest[(c, i)], 3)) for c, i in chosen),
        deeds=tuple(dict.fromkeys(deed.cls for deed in memory.deeds.get(episode.id, ()))),
    )


def _report(memory: Memory, episode: Episode) -> EpisodeReport:
    return EpisodeReport(
        id=episode.id,
        times=episode.times,
        first=episode.first,
        last=episode.last,
        learning_rate=round(episode.learning_rate, 4),
        vigilance=round(episode.vigilance, 4),
        events=tuple(EpisodeEvent(event, round(episode.weights[event], 4)) for event in _in_order(episode)),
        deeds=tuple(EpisodeDeed(d.cls, d.params, round(d.weight, 4)) for d in memory.deeds.get(episode.id, ())),
    )


def _in_order(episode: Episode) -> Iterable[int]:
    return sorted(episode.weights, key=lambda event: (episode.weights[event], event))
