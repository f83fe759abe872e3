"""What the store keeps: the categories of EM-ART and the deeds of its episodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from app.memory.deeds import Deed
from app.memory.em_art import Changes, Episode, Event


@dataclass(frozen=True, slots=True)
class Kept:
    """All that is remembered; ``deeds`` by episode."""

    events: tuple[Event, ...] = ()
    episodes: tuple[Episode, ...] = ()
    deeds: Mapping[int, tuple[Deed, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Update:
    """What is to be kept: ``changes`` of the categories, and the deeds of episodes that have others now."""

    changes: Changes
    deeds: Mapping[int, tuple[Deed, ...]] = field(default_factory=dict)
