"""Which emotion a face and a voice show, and how much. Pure.

In the first HBBA the face is a sum of poses weighed by the emotions as they are (``IRL-1``'s ``jn0_face_expression``).
Here one emotion shows at a time, so that people can read it and it has one reason, with hysteresis, so that a face does
not flicker:

- An emotion that reaches ``begins`` shows; of several, the strongest.
- It stays until it is below ``ends``, or until another one exceeds it by ``MARGIN`` and has reached ``begins``.
- How strongly it shows follows it in steps of ``STEP``, to ``most`` at most.

While emotions stay as they are, what is shown changes once at most, and then stays.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.attention.emotions import EMOTIONS
from app.messages import Emotion, ShownEmotion

STEP: Final = 0.25
"""Strengths have such steps: each change of a desire is a problem to solve."""
MARGIN: Final = 0.1
"""Another emotion must be stronger by so much to show instead."""


@dataclass(frozen=True, slots=True)
class ShowingLimits:
    """``begins``: an emotion this strong begins to show, over 0; ``ends``: below it, it shows no more, less than
    ``begins``. ``most``: the greatest strength that shows, ``STEP`` to 1."""

    begins: float = 0.5
    ends: float = 0.3
    most: float = 0.75


class Showing:
    """What shows of what is felt."""

    def __init__(self, limits: ShowingLimits | None = None) -> None:
        self._limits = limits or ShowingLimits()
        #: The emotion that shows, and how strongly, as if there were no ``most``.
        self._shown: ShownEmotion | None = None

    def update(self, felt: Mapping[Emotion, float]) -> ShownEmotion | None:
        """What shows now, without a desire; ``felt`` are the emotions' intensities, 0 to 1."""
        emotion = self._chosen(felt)
        if emotion is None:
            self._shown = None
            return None
        before = self._shown.strength if self._shown is not None and self._shown.emotion == emotion else None
        self._shown = ShownEmotion(emotion, stepped(felt[emotion], before))
        return ShownEmotion(emotion, min(self._shown.strength, self._limits.most))

    def _chosen(self, felt: Mapping[Emotion, float]) -> Emotion | None:
        limits = self._limits
        # Of equals the first.
        strongest = max(EMOTIONS, key=lambda each: felt.get(each, 0.0))
        now = None if self._shown is None else self._shown.emotion
        if now is not None and felt.get(now, 0.0) >= limits.ends and felt[now] + MARGIN >= felt[strongest]:
            return now
        if felt.get(strongest, 0.0) >= limits.begins:
            return strongest
        return now if now is not None and felt.get(now, 0.0) >= limits.ends else None


def stepped(intensity: float, before: float | None) -> float:
    """``intensity`` in whole steps of :data:`STEP`, one at least; ``before`` stays while it is near enough: from half a
    step below it to a whole one above."""
    if before is not None and before - STEP / 2 <= intensity < before + STEP:
        return before
    return max(STEP, math.floor(intensity / STEP + 1e-9) * STEP)
