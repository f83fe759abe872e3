"""Claps and calls, codes that are shown, sentences out of what is said, times of a schedule. Pure parts."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import Final

from app.messages import QRCode, QRCodes
from app.modules.motivations.tour_guide.entering import ON_THE_WAY
from app.modules.motivations.tour_guide.progress import Called, Clapped, CodeRead, State
from app.speech.text_spans import sentences_of
from app.tours.model import Slot

#: Claps in a row are no further apart (s).
CLAPS_APART_S: Final = 1.2
#: A noise and a voice that are no further apart (s) are one call: voices are located some tenths of a second later.
CALL_WITHIN_S: Final = 1.0
#: A code is shown again once it was out of view for so long (s).
CODE_AGAIN_S: Final = 60.0
#: Codes that visitors hold are no farther (m); a sheet of paper is read from there, and few posters hang so near.
CODE_WITHIN_M: Final = 1.5
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


class Calls:
    """Finds calls: loud noises with a voice at the same time, which a clap or a door has not."""

    def __init__(self) -> None:
        self._noise = self._voice = -math.inf

    def hear(self, stamp: float) -> None:
        """A loud noise began at ``stamp`` (s)."""
        self._noise = stamp

    def locate(self, stamp: float) -> None:
        """A voice sounds at ``stamp`` (s)."""
        self._voice = stamp

    def called(self) -> Called | None:
        """The call that was heard since this was asked last; None where there was none."""
        if math.isinf(self._noise) or abs(self._noise - self._voice) > CALL_WITHIN_S:
            return None
        self._noise = -math.inf
        return Called()


class ShownCodes:
    """Finds the QR codes that people show to the robot: near ones that did not hang along its way."""

    def __init__(self) -> None:
        self._last: dict[str, float] = {}

    def read(self, codes: QRCodes, state: State) -> list[CodeRead]:
        """Those of ``codes`` that are shown while the guide is in ``state``, each text again only after a minute out
        of view. One that is held up early counts once the guide listens."""
        stamp, known = codes.stamp, {text for text, at in self._last.items() if codes.stamp - at <= CODE_AGAIN_S}
        texts = {code.text for code in codes.codes}
        near = {code.text for code in codes.codes if _is_near(code)}
        shown = sorted(near - known) if state == "listening" else []
        # What is passed on the way hangs there.
        counts = known | set(shown) | (texts if state in ON_THE_WAY else set())
        self._last = {text: stamp if text in texts else self._last[text] for text in counts}
        return [CodeRead(text) for text in shown]


def _is_near(code: QRCode) -> bool:
    """Whether somebody may hold ``code``; one too near for its distance to be measured, too."""
    return code.p_BQ is None or math.hypot(code.p_BQ[0], code.p_BQ[1]) <= CODE_WITHIN_M


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
