"""Short-term memory: what was perceived and done lately, as one input of EM-ART. Pure.

Source: F. Leconte, F. Ferland, F. Michaud (2015), with its durations: what was perceived stays for a while, persons and
objects for less once the robot has gone elsewhere; when nothing of persons, objects and desires is left, the episode is
over.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from app.memory.em_art import Pattern

#: How long (s) an item stays after it was perceived last, by channel.
DURATIONS: Final[Mapping[str, float]] = MappingProxyType(
    {"person": 30.0, "object": 30.0, "place": 600.0, "emotion": 15.0, "desire": 3.0}
)
#: After the place has changed, persons and objects that are not perceived there stay so long (s).
MOVED_S: Final = 3.0
#: Without an item of these, there is silence.
SPEAKING: Final = frozenset({"person", "object", "desire"})
#: A channel has so many items at most; the one perceived longest ago goes first.
MOST_ITEMS: Final = 12
#: Of these, nothing makes a new input by itself; nor does an item of a lower activation than this.
QUIET: Final = frozenset({"emotion"})
NOTABLE: Final = 0.5


class ShortTermMemory:
    """Items by channel, each with an activation in [0, 1] and the time (s) at which it ends."""

    def __init__(self, durations: Mapping[str, float] = DURATIONS) -> None:
        self._durations = durations
        self._items: dict[str, dict[str, tuple[float, float]]] = {channel: {} for channel in durations}

    def perceive(self, channel: str, items: Mapping[str, float], now: float) -> None:
        """``items`` with their activations are perceived at ``now`` (s)."""
        ends = now + self._durations[channel]
        kept = self._items[channel]
        for item, activation in items.items():
            kept.pop(item, None)
            kept[item] = (activation, ends)
        while len(kept) > MOST_ITEMS:
            del kept[next(iter(kept))]

    def be_at(self, place: str, now: float) -> bool:
        """The robot is at ``place``, and at no other; whether it was elsewhere before, or nowhere known."""
        moved = place not in self._items["place"]
        if moved:
            self._items["place"].clear()
            for channel in ("person", "object"):
                shortened = {i: (a, min(ends, now + MOVED_S)) for i, (a, ends) in self._items[channel].items()}
                self._items[channel] = shortened
        self.perceive("place", {place: 1.0}, now)
        return moved

    def pattern(self, now: float) -> Pattern:
        """What is present at ``now`` (s): activations by item by channel; channels without any are left out."""
        for items in self._items.values():
            for item in [item for item, (_, ends) in items.items() if ends <= now]:
                del items[item]
        return {
            channel: {item: activation for item, (activation, _) in items.items()}
            for channel, items in self._items.items()
            if items
        }

    def clear(self) -> None:
        """Nothing is present."""
        for items in self._items.values():
            items.clear()


def is_silent(pattern: Pattern) -> bool:
    """Whether no one and nothing is there, and nothing is done."""
    return not SPEAKING & pattern.keys()


def notable(pattern: Pattern) -> frozenset[tuple[str, str]]:
    """The items, each with its channel, whose beginning is an input. That something has ended is none: else the robot
    would be back in the first event after each thing done, and the order of its events would say nothing."""
    return frozenset(
        (channel, item)
        for channel, items in pattern.items()
        if channel not in QUIET
        for item, activation in items.items()
        if activation >= NOTABLE
    )
