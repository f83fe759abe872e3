"""Playback of one utterance: frames at the loudspeaker's pace, and the word and the mouth by time. No clock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.speech.utterance import Utterance
from app.speech.visemes import Viseme

#: Length (s) of a frame.
FRAME_S = 0.04


class UtterancePlayback:
    """``utterance`` played from ``began`` (s) on, with samples times ``volume``."""

    def __init__(self, utterance: Utterance, began: float, volume: float = 1.0) -> None:
        self.utterance = utterance
        self.began = began
        self._volume = volume
        self._sent = 0

    @property
    def ends(self) -> float:
        """The time (s) at which its last sample has been played."""
        return self.began + self.utterance.duration_s

    def frames_until(self, time_s: float) -> list[NDArray[np.int16]]:
        """The frames (N, 1) that begin before ``time_s`` and were not given yet."""
        size = round(FRAME_S * self.utterance.rate)
        samples = self.utterance.samples
        frames = []
        while self._sent < len(samples) and self.began + self._sent / self.utterance.rate < time_s:
            frame = samples[self._sent : self._sent + size, None]
            frames.append(np.rint(frame * self._volume).astype(np.int16))
            self._sent += len(frame)
        return frames

    def at(self, time_s: float) -> tuple[int, int, Viseme]:
        """Begin and end of the word that is heard at ``time_s``, and the mouth."""
        elapsed_s = time_s - self.began
        index = self.utterance.word_at(elapsed_s)
        word = self.utterance.words[index] if index >= 0 else None
        begin, end = (word.begin, word.end) if word is not None else (0, 0)
        return begin, end, self.utterance.viseme_at(elapsed_s)
