"""Claps out of loud noises, sentences out of what is said, times of a schedule. Small pure parts."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import Final

from app.modules.motivations.tour_guide.progress import Clapped
from app.speech.text_spans import sentences_of
from app.tours.model import Slot

#: Claps in a row are no further apart (s).
CLAPS_APART_S: Final = 1.2
_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


class Claps:
    """Counts loud noises that follow one another."""

    def __init__(self) -> None:
        self._times = 0
        self._last = -math.inf

    def hear(self, stamp: float) -> None:
        """A loud noise began at ``stamp`` (s)."""
        self._times = self._times + 1 if stamp - self._last <= CLAPS_APART_S else 1
        self._last = stamp

    def counted(self, now: float) -> Clapped | None:
        """The claps of a row that is over; None while none is."""
        if self._times == 0 or now - self._last <= CLAPS_APART_S:
            return None
        times, self._times = self._times, 0
        return Clapped(times)


def sentence_number(text: str, said: str, before: int) -> int:
    """Which sentence of ``text`` is ``said``, counted from 0: the first from ``before`` on; ``before`` if none is."""
    for number, (begin, end) in enumerate(sentences_of(text)):
        if number >= before and text[begin:end] == said:
            return number
    return before


def is_due(slots: Iterable[Slot], since: float, now: float) -> bool:
    """Whether a time of ``slots`` lies in ]``since``, ``now``] (Unix time, s), of the same minute at most."""
    local = time.localtime(now)
    begin = now - local.tm_sec - now % 1
    if not since < begin <= now:
        return False
    day, at = _DAYS[local.tm_wday], f"{local.tm_hour:02}:{local.tm_min:02}"
    return any(day in slot.days and at in slot.times for slot in slots)
