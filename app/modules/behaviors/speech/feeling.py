"""The manner of speaking that an emotion gives, slightly changed from the usual. Pure.

Directions are those of people (I. R. Murray and J. L. Arnott, *Toward the simulation of emotion in synthetic speech*,
J. Acoust. Soc. Am. 93(2), 1993, table I): joy, anger and fear raise the voice, anger and fear hasten it, fear most;
sadness is a little lower and slower. Sizes are smaller than theirs, so that words stay as clear as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from app.messages import Emotion, ShownEmotion
from app.speech.manner import USUAL, Manner

MOST_CHANGE: Final = 0.12
"""Neither rate nor pitch differs from the usual by a greater share."""
MANNERS: Final[Mapping[Emotion, Manner]] = MappingProxyType(
    {
        "joy": Manner(1.05, 1.10),
        "anger": Manner(1.08, 1.06),
        "sadness": Manner(0.90, 0.95),
        "fear": Manner(1.12, 1.12),
    }
)
"""By emotion, at a strength of 1."""


def manner_of(shown: ShownEmotion | None) -> Manner:
    """The manner of speaking while an emotion shows, in proportion to its strength; the usual one while none does."""
    if shown is None:
        return USUAL
    whole, share = MANNERS[shown.emotion], min(max(shown.strength, 0.0), 1.0)
    return Manner(1.0 + share * (whole.rate - 1.0), 1.0 + share * (whole.pitch - 1.0))
