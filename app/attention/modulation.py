"""Emotions raise the intensity of desires that are ignored, so that intentions change (thesis 2.2.2 and 5). Pure.

How, is not published; here it is made so that it cannot swing:

- *Ignored* is the strongest desire of a class that is wanted, not security, and that attention selects nothing for,
  though desires have been the same for a while. An emotion that the neglect of its class has fed raises it, by at most
  ``most``.
- Once something is selected for it, it is raised no further, but less as that emotion goes, and not at all once it has
  lost again what it was given.
- It is raised again only after desires have changed, and not before ``again_s`` have gone by.

While desires stay as they are, what is raised has no effect before it is selected, and only falls from then on: so
selections change a limited number of times, and settle. Within a class the order of desires stays.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from app.attention.desires import Desire, may_be_raised
from app.attention.emotions import EMOTIONS, Shares, strongest
from app.messages import Emotion, Modulation

STEP: Final = 0.25
"""Intensities are raised in such steps, so that attention does not decide at every breath."""

_RAISING: Final = tuple(emotion for emotion in EMOTIONS if emotion != "joy")


@dataclass(frozen=True, slots=True)
class ModulationLimits:
    """``most``: the greatest rise of an intensity, over 0 and at most 8. ``settle_s``: desires must have been the same
    for so long (s) before what is not selected counts as ignored: longer than the hysteresis of attention holds
    selections. ``again_s``: a class that was raised is raised again only after so long (s)."""

    most: float = 2.0
    settle_s: float = 5.0
    again_s: float = 120.0


@dataclass(slots=True)
class _Class:
    desire: str = ""
    by: float = 0.0
    emotion: Emotion = "anger"
    #: Something was selected for it since desires changed: it is not ignored.
    had_its_turn: bool = False
    began: float | None = None


class Modulator:
    """Which desires are raised, and by how much."""

    def __init__(self, limits: ModulationLimits | None = None) -> None:
        self._limits = limits or ModulationLimits()
        self._classes: dict[str, _Class] = {}
        self._key: Hashable = None
        self._since = -math.inf

    def update(
        self, now: float, desires: Iterable[Desire], intended: Iterable[str], shares: Mapping[Emotion, Shares]
    ) -> dict[str, Modulation]:
        """What is raised at ``now`` (s), by id of the desire.

        ``desires`` are all there are, as they were stated; ``intended`` the ids of those that attention serves;
        ``shares`` what each emotion comes from.
        """
        every = strongest(desires)
        wanted = {cls: desire for cls, desire in every.items() if may_be_raised(desire)}
        self._follow(now, every, wanted)
        served = frozenset(intended)
        settled = now - self._since >= self._limits.settle_s
        for cls, desire in wanted.items():
            known = self._classes.setdefault(cls, _Class())
            if known.desire != desire.id:
                known.desire, known.by = desire.id, 0.0
            self._judge(known, now, _fed(shares, cls), ignored=settled and desire.id not in served)
            if settled and desire.id in served:
                known.had_its_turn = True
        return {
            known.desire: Modulation(known.by, known.emotion)
            for cls, known in self._classes.items()
            if cls in wanted and known.by > 0
        }

    def clear(self) -> None:
        """Time has jumped: nothing is raised."""
        self._classes.clear()
        self._key, self._since = None, -math.inf

    def _follow(self, now: float, every: Mapping[str, Desire], wanted: Collection[str]) -> None:
        key = tuple(sorted((d.id, d.intensity, d.utility, d.security) for d in every.values()))
        if key == self._key:
            return
        self._key, self._since = key, now
        for cls, known in tuple(self._classes.items()):
            if known.began is None or now - known.began >= self._limits.again_s:
                known.had_its_turn = False
                if cls not in wanted:
                    del self._classes[cls]
            if cls not in wanted:
                known.by = 0.0

    def _judge(self, known: _Class, now: float, fed: tuple[float, Emotion], *, ignored: bool) -> None:
        share, emotion = fed
        wish = self._limits.most * min(1.0, share)
        target = math.floor(wish / STEP + 1e-9) * STEP
        if ignored and known.had_its_turn:
            known.by = 0.0
        elif ignored and target > known.by:
            known.began = now if known.by == 0 else known.began
            known.by, known.emotion = target, emotion
        if target < known.by and wish <= known.by - STEP / 2:
            known.by = target


def _fed(shares: Mapping[Emotion, Shares], cls: str) -> tuple[float, Emotion]:
    """The greatest share that ``cls`` has in an emotion that raises, and which."""
    return max(((shares.get(emotion, {}).get(cls, 0.0), emotion) for emotion in _RAISING), key=lambda each: each[0])
