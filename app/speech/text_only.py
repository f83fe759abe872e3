"""An engine without sound: subtitles and mouth alone, with estimated times."""

from __future__ import annotations

import numpy as np

from app.speech.estimate import estimated_duration_s, estimated_mouth, estimated_words
from app.speech.manner import USUAL, Manner
from app.speech.utterance import Utterance

_RATE = 16_000


class TextOnly:
    """Gives a text the time that it takes to say or read, at ``words_per_minute``."""

    def __init__(self, words_per_minute: float = 160.0) -> None:
        self._words_per_minute = words_per_minute

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        """No samples; estimated times, which no ``manner`` changes: it is read, not heard."""
        duration_s = estimated_duration_s(text, self._words_per_minute)
        words = estimated_words(text, duration_s)
        mouth = estimated_mouth(text, words)
        return Utterance(text, np.zeros(0, np.int16), _RATE, duration_s=duration_s, words=words, mouth=mouth)
