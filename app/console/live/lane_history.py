"""The recent past of the lanes, for pages that come later: twice a second, what changes seldom only as it changes."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from app.console.live.messages import LanePast, LanesHistory, LaneSpell
from app.console.wire import frame
from app.messages import LaneRow, Lanes

PERIOD_S = 0.5
#: A sample that comes so much early (s) is noted, or of those that come twice a second every other one would not be.
_EARLY_S = 0.02
SPAN_S = 600.0
MOST_SAMPLES = round(SPAN_S / PERIOD_S)
#: The frame stays under this; of a past too eventful for that, the older part is left out.
MOST_BYTES = 200_000

#: What a row keeps for as long as it stays the same.
HELD = ("intensity", "utility", "divisor", "divisors", "state", "text")

_ABSENT = LaneRow(
    cls="", intensity=None, utility=None, rate=None, divisor=math.inf, divisors={}, state="undesired", text=""
)


@dataclass(frozen=True, slots=True)
class Spell:
    """``values`` of :data:`HELD`, which a class has had since sample ``number`` (counted from the first ever)."""

    number: int
    values: tuple[Any, ...]


class LaneHistory:
    """The last ``most_samples`` samples of the lanes; noting one more takes constant time."""

    def __init__(self, classes: Iterable[str], most_samples: int = MOST_SAMPLES) -> None:
        self._most = most_samples
        self._classes = tuple(classes)
        self.clear()

    def clear(self) -> None:
        """Begin with no past."""
        self._count = 0
        self._due = -math.inf
        self._stamps: deque[float] = deque(maxlen=self._most)
        self._rates: dict[str, deque[float | None]] = {cls: deque(maxlen=self._most) for cls in self._classes}
        self._spells: dict[str, deque[Spell]] = {cls: deque() for cls in self._rates}

    def add(self, lanes: Lanes) -> None:
        """Note ``lanes``, unless others were noted a moment ago."""
        if lanes.stamp < self._due:
            return
        self._due = lanes.stamp + PERIOD_S - _EARLY_S
        self._stamps.append(lanes.stamp)
        oldest = self._count + 1 - len(self._stamps)
        rows = {row.cls: row for row in lanes.rows}
        for cls in self._classes:
            # A recording may have other classes than the program that it is replayed with.
            row = rows.get(cls, _ABSENT)
            self._rates[cls].append(row.rate)
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
        samples = len(self._stamps)
        while True:
            text = frame("lanes_history", self._message(samples))
            if len(text) <= most_bytes or samples <= 1:
                return text
            samples //= 2

    def _message(self, samples: int) -> LanesHistory:
        first = self._count - samples
        return LanesHistory(
            stamps=tuple(round(stamp, 3) for stamp in _last(self._stamps, samples)),
            rows=tuple(
                LanePast(cls, _last(rates, samples), _spells(self._spells[cls], first))
                for cls, rates in self._rates.items()
            ),
        )


def _last(values: deque[Any], count: int) -> tuple[Any, ...]:
    return tuple(islice(values, len(values) - count, None))


def _spells(spells: Sequence[Spell], first: int) -> tuple[LaneSpell, ...]:
    """The spells from sample ``first`` on, their beginnings counted from it."""
    held = [spell for spell in spells if spell.number <= first][-1:]
    later = [spell for spell in spells if spell.number > first]
    return tuple(
        LaneSpell(at=max(0, spell.number - first), **dict(zip(HELD, spell.values, strict=True)))
        for spell in held + later
    )
