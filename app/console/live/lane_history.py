"""The last hour of the lanes, for pages that come later: twice a second, what changes seldom only as it changes."""

from __future__ import annotations

import math
import sys
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.console.live.lane_buckets import Floats, Indices, aggregated, bucket_starts, thinned
from app.console.live.messages import LanePast, LanesHistory, LaneSpell
from app.console.records.lanes import LaneBuckets, LaneChange, LanesPast
from app.console.wire import frame
from app.messages import LaneRow, Lanes

PERIOD_S = 0.5
#: A sample that comes so much early (s) is noted, or of those that come twice a second every other one would not be.
_EARLY_S = 0.02
#: A clock set back by more than this begins another past.
SET_BACK_S = 5.0
SPAN_S = 3600.0
MOST_SAMPLES = round(SPAN_S / PERIOD_S)
#: The frame has the newest of them, and stays under this; of a past too eventful for that, the older part is left out.
FRAME_SAMPLES = round(600.0 / PERIOD_S)
MOST_BYTES = 200_000

#: What a row keeps for as long as it stays the same.
HELD = ("intensity", "utility", "divisor", "divisors", "state", "text")

_DIVISOR, _STATE = HELD.index("divisor"), HELD.index("state")
#: From what matters least of what a lane can be for an instant.
_SEVERITY = {"undesired": 0, "needed": 1, "fulfilled": 2, "degraded": 3, "inhibited": 4, "unfulfilled": 5}

_ABSENT = LaneRow(
    cls="", intensity=None, utility=None, rate=None, divisor=math.inf, divisors={}, state="undesired", text=""
)


@dataclass(frozen=True, slots=True)
class Spell:
    """``values`` of :data:`HELD`, which a class has had since sample ``number`` (counted from the first ever)."""

    number: int
    values: tuple[Any, ...]


class LaneHistory:
    """The last ``most_samples`` samples of the lanes; noting one more takes constant time.

    Stamps and rates are rings of 8 bytes a sample, which for an hour of 30 classes are 1.8 MB; besides there is a spell
    for each change.
    """

    def __init__(self, classes: Iterable[str], most_samples: int = MOST_SAMPLES) -> None:
        self._most = most_samples
        self._classes = tuple(classes)
        self._stamps = np.empty(most_samples)
        self._rates = np.empty((len(self._classes), most_samples))
        self.clear()

    def clear(self) -> None:
        """Begin with no past."""
        self._count = 0
        self._due = -math.inf
        self._spells: dict[str, deque[Spell]] = {cls: deque() for cls in self._classes}

    def add(self, lanes: Lanes) -> None:
        """Note ``lanes``, unless others were noted a moment ago. Those of an earlier time begin another past."""
        if lanes.stamp < self._due:
            if lanes.stamp >= self._due - SET_BACK_S:
                return
            self.clear()
        self._due = lanes.stamp + PERIOD_S - _EARLY_S
        slot = self._count % self._most
        self._stamps[slot] = lanes.stamp
        oldest = max(0, self._count + 1 - self._most)
        rows = {row.cls: row for row in lanes.rows}
        for number, cls in enumerate(self._classes):
            # A recording may have other classes than the program that it is replayed with.
            row = rows.get(cls, _ABSENT)
            self._rates[number, slot] = math.nan if row.rate is None else row.rate
            spells = self._spells[cls]
            values = tuple(getattr(row, name) for name in HELD)
            if not spells or spells[-1].values != values:
                spells.append(Spell(self._count, values))
            # The last spell that began at or before the oldest sample holds there.
            while len(spells) > 1 and spells[1].number <= oldest:
                spells.popleft()
        self._count += 1

    def frame(self, most_bytes: int = MOST_BYTES) -> str:
        """The message ``lanes_history`` of at most ``most_bytes`` (of at least one sample, if there is any)."""
        samples = min(self._count, self._most, FRAME_SAMPLES)
        while True:
            text = frame("lanes_history", self._message(samples))
            if len(text) <= most_bytes or samples <= 1:
                return text
            samples //= 2

    def between(self, begin: float, end: float) -> LaneStretch:
        """A copy of the lanes from ``begin`` to ``end`` (robot's clock, s), as far as they are kept."""
        slots = self._slots(min(self._count, self._most))
        known = self._stamps[slots]
        low, high = np.searchsorted(known, begin), np.searchsorted(known, end, side="right")
        return LaneStretch(
            begin=begin,
            end=end,
            oldest=float(known[0]) if len(known) else None,
            first=self._count - len(known) + int(low),
            stamps=known[low:high],
            rates=self._rates[:, slots[low:high]],
            spells={cls: list(spells) for cls, spells in self._spells.items()},
        )

    def _slots(self, samples: int) -> Indices:
        """Where in the rings the newest ``samples`` are."""
        return np.arange(self._count - samples, self._count) % self._most

    def _message(self, samples: int) -> LanesHistory:
        first = self._count - samples
        slots = self._slots(samples)
        return LanesHistory(
            stamps=_milliseconds(self._stamps[slots]),
            rows=tuple(
                LanePast(cls, _numbers(rates[slots]), _spells(self._spells[cls], first))
                for cls, rates in zip(self._classes, self._rates, strict=True)
            ),
        )


@dataclass(frozen=True, slots=True)
class LaneStretch:
    """The lanes between two stamps, apart from the history: what is made of them may take its time in a thread."""

    begin: float
    end: float
    oldest: float | None
    #: Number of the first sample, and of each its stamp.
    first: int
    stamps: Floats
    #: One row for each class of ``spells``.
    rates: Floats
    spells: Mapping[str, Sequence[Spell]]

    def in_buckets(self, points: int) -> LanesPast:
        """At most ``points`` buckets of it."""
        starts = bucket_starts(self.stamps, self.begin, self.end, points)
        whole = len(starts) == len(self.stamps)
        return LanesPast(
            oldest=self.oldest,
            bucket_s=0.0 if whole else (self.end - self.begin) / points,
            stamps=_milliseconds(self.stamps[starts]),
            ends=_milliseconds(self.stamps[np.append(starts[1:], len(self.stamps)) - 1]) if len(starts) else (),
            rows=tuple(
                self._buckets(cls, spells, starts, rates, whole=whole)
                for (cls, spells), rates in zip(self.spells.items(), self.rates, strict=True)
            ),
        )

    def _buckets(
        self, cls: str, spells: Sequence[Spell], starts: Indices, rates: Floats, *, whole: bool
    ) -> LaneBuckets:
        low, high, last = aggregated(rates, starts)
        held = _held(spells, self.first, self.first + len(self.stamps)) if len(starts) else []
        numbers = [max(0, spell.number - self.first) for spell in held]
        places = np.searchsorted(starts, numbers, side="right").tolist()
        stamps = _milliseconds(self.stamps[numbers]) if held else ()
        kept = thinned(zip(held, places, stamps, strict=True), lambda each: each[1], lambda each: _weight(each[0]))
        return LaneBuckets(
            cls,
            rate=_numbers(last),
            low=() if whole else _numbers(low),
            high=() if whole else _numbers(high),
            changes=tuple(LaneChange(stamp, *spell.values) for spell, _, stamp in kept),
        )


def _milliseconds(stamps: Floats) -> tuple[float, ...]:
    return tuple(np.round(stamps, 3).tolist())


def _numbers(values: Floats) -> tuple[float | None, ...]:
    return tuple(None if math.isnan(value) else value for value in values.tolist())


def _weight(spell: Spell) -> tuple[float, float]:
    """The more closed, the more; of those as closed, the worse for what is desired."""
    return spell.values[_DIVISOR], _SEVERITY[spell.values[_STATE]]


def _held(spells: Sequence[Spell], first: int, stop: int) -> list[Spell]:
    """The spells that hold at samples ``first`` to ``stop`` (without it)."""
    before = [spell for spell in spells if spell.number <= first][-1:]
    return before + [spell for spell in spells if first < spell.number < stop]


def _spells(spells: Sequence[Spell], first: int) -> tuple[LaneSpell, ...]:
    """The spells from sample ``first`` on, their beginnings counted from it."""
    return tuple(
        LaneSpell(at=max(0, spell.number - first), **dict(zip(HELD, spell.values, strict=True)))
        for spell in _held(spells, first, sys.maxsize)
    )
