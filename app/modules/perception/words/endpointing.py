"""Endpointing: where an utterance begins and ends, by the probability of speech. Pure; knows no clock."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.voice_activity import CHUNK, SPEECH_RATE, SpeechProbability

#: Chunks (32 ms) of speech of the last _ONSET_OF that begin an utterance, and of none that end it: pauses within a word
#: (before the burst of a plosive) are shorter.
_ONSET, _ONSET_OF, _PAUSE = 2, 3, 10
#: Probability at which speech begins, and under which it ends.
_ENTER, _STAY = 0.5, 0.35
#: Sound (s) before the first chunk of speech and after the last that belongs to the utterance: soft consonants.
_BEFORE_S, _AFTER_S = 0.12, 0.15


@dataclass(frozen=True, slots=True)
class Utterance:
    """Samples ``begin`` to ``end`` of the sound are speech; since ``quiet_from`` there was none before."""

    begin: int
    end: int
    quiet_from: int


class Endpointer:
    """Finds utterances in the sound of one microphone at 16 kHz, numbered from the last reset."""

    def __init__(self) -> None:
        self._probability = SpeechProbability()
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next sample is number 0."""
        self._probability.reset()
        self._recent: deque[bool] = deque(maxlen=_ONSET_OF)
        self._chunks = 0
        self._begin: int | None = None
        self._last = self._quiet_from = 0

    @property
    def speaks(self) -> bool:
        """Whether an utterance goes on."""
        return self._begin is not None

    def update(self, sound: NDArray[np.float32]) -> list[Utterance]:
        """Take the next samples (N,), in [-1, 1); the utterances that they end."""
        return [found for p in self._probability.update(sound) if (found := self._judge(p)) is not None]

    def _judge(self, probability: float) -> Utterance | None:
        now, self._chunks = self._chunks, self._chunks + 1
        if self._begin is None:
            self._recent.append(probability >= _ENTER)
            if sum(self._recent) >= _ONSET:
                first = now - len(self._recent) + 1 + list(self._recent).index(True)
                self._begin, self._last = first, now
            return None
        if probability >= _STAY:
            self._last = now
        if now - self._last < _PAUSE:
            return None
        begin = max(self._quiet_from, self._begin * CHUNK - round(_BEFORE_S * SPEECH_RATE))
        end = (self._last + 1) * CHUNK + round(_AFTER_S * SPEECH_RATE)
        found = Utterance(begin, end, self._quiet_from)
        self._begin, self._quiet_from = None, end
        self._recent.clear()
        return found
