"""EM-ART: events of what is perceived at one time, episodes of events in their order; recognition and anticipation.

    items by channel ─▶ event (the most similar, or a new one) ─▶ order of the last events ─▶ episode recognized
                                                                                        └─▶ events anticipated

Source and functions: :mod:`app.memory.matching`. Weights are kept where they are not 0; those of the complements are
1 less these, and are derived. Not for use from several threads.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final

from app.memory.matching import complement_fit, episode_vigilance, learned, plain_fit, rate_after, rate_before

#: Activations, or weights, by item by channel.
Pattern = Mapping[str, Mapping[str, float]]

#: Relevances of the published short-term memory (0 to 10 there).
RELEVANCES: Final[Mapping[str, float]] = MappingProxyType(
    {"person": 1.0, "object": 1.0, "place": 1.0, "emotion": 0.0, "desire": 0.9}
)


@dataclass(frozen=True, slots=True)
class Parameters:
    """Parameters of EM-ART, with the published defaults.

    ``channels``: relevance in [0, 1] by channel; of a channel with 0, any pattern resonates. ``event_vigilance``,
    ``episode_vigilance`` and ``learning_rate`` are those of new categories. ``decay``: what is left of an event's
    activation with each further input. ``eagerness``: by how much the vigilance of the event anticipated next is lower.
    ``habit``: of episodes that resonate, that with the greatest match times its number of times to this power is
    recognized; 0 as published, where a short episode has the advantage that its first event weighs more. Learned is
    always the one with the greatest match. ``absent_counts``: whether all known items that neither a pattern nor a
    category has count as alike, as published; then events with ten known items of a channel can no longer be
    distinguished by one of them.
    """

    channels: Mapping[str, float] = field(default_factory=lambda: RELEVANCES)
    event_vigilance: float = 0.95
    episode_vigilance: float = 0.55
    learning_rate: float = 0.6
    decay: float = 0.95
    negligible: float = 0.01
    eagerness: float = 0.2
    habit: float = 0.0
    absent_counts: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """A category of the event layer: ``weights`` in ]0, 1] by item by channel; ``used``: how often it was input."""

    id: int
    weights: Pattern
    learning_rate: float
    used: int = 1


@dataclass(frozen=True, slots=True)
class Episode:
    """A category of the episode layer: ``weights`` in ]0, 1] by event; the later an event, the greater its weight.

    ``times``: how often it was closed; ``first``, ``last``: when (robot's clock, s) first and last.
    """

    id: int
    weights: Mapping[int, float]
    learning_rate: float
    vigilance: float
    times: int
    first: float
    last: float


@dataclass(frozen=True, slots=True)
class Anticipated:
    """An event of the recognized episode that is to come, its ``weight`` in it, and the vigilance it has meanwhile."""

    event: int
    weight: float
    vigilance: float


@dataclass(frozen=True, slots=True)
class Recognized:
    """The episode that fits best what has happened so far, its match in [0, 1], and what is to come, next first."""

    episode: int
    match: float
    anticipated: tuple[Anticipated, ...]


@dataclass(frozen=True, slots=True)
class Perceived:
    """What one input is: its ``event``, whether that is ``new`` or was ``anticipated``, and the episode recognized."""

    event: int
    new: bool
    anticipated: bool
    recognized: Recognized | None


@dataclass(frozen=True, slots=True)
class Closed:
    """The episode that what has happened was learned as, and whether it is ``new``."""

    episode: int
    new: bool


@dataclass(frozen=True, slots=True)
class Changes:
    """Categories that changed, to be kept, and ids of those that are gone."""

    events: tuple[Event, ...]
    episodes: tuple[Episode, ...]
    events_gone: tuple[int, ...]
    episodes_gone: tuple[int, ...]


class EMArt:
    """The two layers, and the activations of the events of the episode that is under way."""

    def __init__(
        self,
        parameters: Parameters | None = None,
        *,
        events: Collection[Event] = (),
        episodes: Collection[Episode] = (),
    ) -> None:
        """With the categories that were kept."""
        self.parameters = parameters or Parameters()
        self._events = {event.id: event for event in events}
        self._episodes = {episode.id: episode for episode in episodes}
        self._activations: dict[int, float] = {}
        self._vigilances: dict[int, float] = {}
        self._next_event = max(self._events, default=0) + 1
        self._next_episode = max(self._episodes, default=0) + 1
        self._changed_events: set[int] = set()
        self._changed_episodes: set[int] = set()
        self._gone_events: set[int] = set()
        self._gone_episodes: set[int] = set()

    # --- Reading ---------------------------------------------------------------------------------------------------

    @property
    def events(self) -> Mapping[int, Event]:
        """All events by id."""
        return MappingProxyType(self._events)

    @property
    def episodes(self) -> Mapping[int, Episode]:
        """All episodes by id."""
        return MappingProxyType(self._episodes)

    @property
    def under_way(self) -> tuple[int, ...]:
        """Events of the episode that is under way, in the order of their last input."""
        return tuple(sorted(self._activations, key=self._activations.__getitem__))

    @property
    def nodes(self) -> int:
        """How many input nodes there are: two for each item of an event, for complement coding."""
        return 2 * sum(map(len, self._items().values()))

    # --- Working ---------------------------------------------------------------------------------------------------

    def perceive(self, pattern: Pattern, emotion: float | None = None) -> Perceived:
        """Take an input: activations in [0, 1] by item by channel. ``emotion``: the greatest intensity, 0 to 1; None
        has no effect. Raises ValueError for a channel that there is not, or a number out of range."""
        given = self._checked(pattern)
        expected = self._vigilances
        winner = self._best_event(given)
        new = winner is None
        if winner is None:
            winner = self._next_event
            self._next_event += 1
            rate = rate_after(self.parameters.learning_rate, emotion)
            weights = {
                channel: kept
                for channel, items in given.items()
                if (kept := {item: a for item, a in items.items() if a >= self.parameters.negligible})
            }
            self._events[winner] = Event(winner, weights, rate)
        else:
            self._events[winner] = self._event_learned(self._events[winner], given, emotion)
        self._changed_events.add(winner)
        self._activate(winner)
        recognized = self.recognized()
        self._vigilances = {} if recognized is None else {e.event: e.vigilance for e in recognized.anticipated}
        return Perceived(winner, new, not new and winner in expected, recognized)

    def recognized(self) -> Recognized | None:
        """The episode that the activations of events are most likely of; None where none resonates."""
        return self._fitting(self.parameters.habit)

    def close(self, stamp: float, emotion: float | None = None) -> Closed | None:
        """The episode under way is over: learn it, as the one that is recognized or as a new one; None: there was none.
        ``stamp``: robot's clock, s."""
        if not self._activations:
            return None
        found = self._fitting(habit=0.0)
        given, parameters = self._activations, self.parameters
        self.abandon()
        if found is None:
            id_ = self._next_episode
            self._next_episode += 1
            episode = Episode(
                id_,
                dict(given),
                rate_after(parameters.learning_rate, emotion),
                episode_vigilance(parameters.episode_vigilance, emotion, given),
                times=1,
                first=stamp,
                last=stamp,
            )
        else:
            before = self._episodes[found.episode]
            rate = rate_before(before.learning_rate, emotion)
            weights = learned(before.weights, given, rate, parameters.negligible)
            episode = replace(
                before,
                weights=weights,
                learning_rate=rate_after(rate, emotion),
                vigilance=episode_vigilance(before.vigilance, emotion, weights),
                times=before.times + 1,
                last=stamp,
            )
        self._episodes[episode.id] = episode
        self._changed_episodes.add(episode.id)
        return Closed(episode.id, found is None)

    def abandon(self) -> None:
        """Nothing is under way any more, and nothing is learned of it."""
        self._activations, self._vigilances = {}, {}

    # --- Forgetting ------------------------------------------------------------------------------------------------

    def forget(self, episode: int) -> bool:
        """Remove an episode, with the events that were its own; whether there was one."""
        if self._episodes.pop(episode, None) is None:
            return False
        self._changed_episodes.discard(episode)
        self._gone_episodes.add(episode)
        self._drop_loose_events()
        return True

    def forget_all(self) -> None:
        """Remove everything; ids grow on."""
        self._gone_episodes.update(self._episodes)
        self._episodes.clear()
        self._changed_episodes.clear()
        self.abandon()
        self._drop_loose_events()

    def forget_items(self, channel: str, matches: Callable[[str], bool]) -> None:
        """Remove items of ``channel`` from all events."""
        for event in tuple(self._events.values()):
            items = event.weights.get(channel, {})
            if kept := {item: w for item, w in items.items() if not matches(item)}:
                weights = {**event.weights, channel: kept}
            else:
                weights = {name: each for name, each in event.weights.items() if name != channel}
            if weights != event.weights:
                self._events[event.id] = replace(event, weights=weights)
                self._changed_events.add(event.id)

    def bound(self, *, episodes: int, events: int, since: float) -> tuple[int, ...]:
        """Remove episodes closed last before ``since`` (s), then, of more than ``episodes``, or as long as there are
        more than ``events``, those closed least often, of them the oldest. Returns the removed."""
        by_use = sorted(self._episodes.values(), key=lambda each: (each.times, each.last))
        gone = [each.id for each in by_use if each.last < since]
        for each in gone:
            self.forget(each)
        self._drop_loose_events()
        rest = [each.id for each in by_use if each.id in self._episodes]
        while rest and (len(rest) > episodes or len(self._events) > events):
            gone.append(rest[0])
            self.forget(rest.pop(0))
        return tuple(gone)

    def take_changes(self) -> Changes:
        """What has changed since the last call, of events only those that an episode has."""
        kept = {event for episode in self._episodes.values() for event in episode.weights}
        changed = self._changed_events & kept
        changes = Changes(
            tuple(self._events[each] for each in sorted(changed)),
            tuple(self._episodes[each] for each in sorted(self._changed_episodes)),
            tuple(sorted(self._gone_events)),
            tuple(sorted(self._gone_episodes)),
        )
        self._changed_events -= changed
        self._changed_episodes.clear()
        self._gone_events.clear()
        self._gone_episodes.clear()
        return changes

    # --- Inside ----------------------------------------------------------------------------------------------------

    def _items(self) -> Mapping[str, set[str]]:
        """All items of events, by channel."""
        known: dict[str, set[str]] = {channel: set() for channel in self.parameters.channels}
        for event in self._events.values():
            for channel, items in event.weights.items():
                known[channel].update(items)
        return known

    def _activate(self, event: int) -> None:
        """The order memory: ``event`` is the last, all others are the weaker the older. An event too weak to be learned
        is no longer of the episode under way, which is so bounded."""
        decay, negligible = self.parameters.decay, self.parameters.negligible
        weaker = {each: decay * a for each, a in self._activations.items()}
        self._activations = {each: a for each, a in weaker.items() if a >= negligible} | {event: 1.0}
        if len(self._activations) < len(weaker.keys() | {event}):
            self._drop_loose_events()

    def _checked(self, pattern: Pattern) -> Pattern:
        for channel, items in pattern.items():
            if channel not in self.parameters.channels:
                allowed = ", ".join(self.parameters.channels)
                raise ValueError(f"{channel!r} is no channel of this memory; there are: {allowed}")
            for item, a in items.items():
                if not 0 <= a <= 1:
                    raise ValueError(f"{channel} {item}: an activation is from 0 to 1, not {a!r}")
        return pattern

    def _best_event(self, given: Pattern) -> int | None:
        """The event that resonates on all channels with the largest sum of matches, the first of equals."""
        best, best_match = None, -1.0
        known = self._items() if self.parameters.absent_counts else {}
        for event in self._events.values():
            vigilance = self._vigilances.get(event.id, self.parameters.event_vigilance)
            total = 0.0
            for channel, relevance in self.parameters.channels.items():
                items, weights = given.get(channel, {}), event.weights.get(channel, {})
                absent = len(known[channel] - items.keys() - weights.keys()) if known else 0
                fit = complement_fit(items, weights, absent)
                if not fit.resonates(vigilance, relevance):
                    break
                total += fit.match
            else:
                if total > best_match:
                    best, best_match = event.id, total
        return best

    def _event_learned(self, event: Event, given: Pattern, emotion: float | None) -> Event:
        rate = rate_before(event.learning_rate, emotion)
        weights = {}
        for channel in self.parameters.channels:
            after = learned(event.weights.get(channel, {}), given.get(channel, {}), rate, self.parameters.negligible)
            if after:
                weights[channel] = after
        return Event(event.id, weights, rate_after(rate, emotion), event.used + 1)

    def _fitting(self, habit: float) -> Recognized | None:
        best, best_score = None, 0.0
        for episode in self._episodes.values():
            fit = plain_fit(self._activations, episode.weights)
            score = fit.match * episode.times**habit
            if fit.resonates(episode.vigilance) and score > best_score:
                best, best_score = Recognized(episode.id, fit.match, ()), score
        if best is None:
            return None
        return replace(best, anticipated=self._anticipated(self._episodes[best.episode]))

    def _anticipated(self, episode: Episode) -> tuple[Anticipated, ...]:
        """Events of ``episode`` that come after the latest of its events that happened, and have not, next first."""
        happened = [event for event in self._activations if event in episode.weights]
        latest = max(happened, key=self._activations.__getitem__)
        to_come = sorted(
            (weight, event)
            for event, weight in episode.weights.items()
            if weight >= episode.weights[latest] and event not in self._activations
        )
        eagerness = self.parameters.eagerness
        return tuple(
            Anticipated(event, weight, self.parameters.event_vigilance - (eagerness - i * eagerness / len(to_come)))
            for i, (weight, event) in enumerate(to_come)
        )

    def _drop_loose_events(self) -> None:
        """Remove events that no episode has; those of the one under way are no longer kept, until it is over."""
        kept = {event for episode in self._episodes.values() for event in episode.weights}
        for event in self._events.keys() - kept:
            self._gone_events.add(event)
            if event in self._activations:
                self._changed_events.add(event)
            else:
                del self._events[event]
                self._changed_events.discard(event)
