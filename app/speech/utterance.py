"""An utterance: the sound of a text, and the times of its words and of the mouth."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from app.speech.manner import USUAL, Manner
from app.speech.visemes import Viseme


class SpeechError(Exception):
    """A text cannot be spoken; the message is one sentence with the reason and the remedy."""


@dataclass(frozen=True, slots=True)
class SpokenWord:
    """Characters ``begin`` to ``end`` of the text, spoken from ``start_s`` to ``end_s`` of the utterance."""

    begin: int
    end: int
    start_s: float
    end_s: float


@dataclass(frozen=True, slots=True)
class MouthMoment:
    """The mouth from ``start_s`` (s) of the utterance on."""

    start_s: float
    viseme: Viseme


@dataclass(frozen=True, slots=True, eq=False)
class Utterance:
    """``text`` as spoken: ``samples`` (N,) int16 at ``rate``, N = 0 for an engine without sound.

    ``duration_s``: length, the pause at the end included. ``words`` and ``mouth`` in order of time.
    """

    text: str
    samples: NDArray[np.int16]
    rate: int
    duration_s: float
    words: tuple[SpokenWord, ...]
    mouth: tuple[MouthMoment, ...]

    def word_at(self, time_s: float) -> int:
        """Index of the newest word that began by ``time_s``; -1 before the first."""
        return bisect_right(self.words, time_s, key=lambda word: word.start_s) - 1

    def viseme_at(self, time_s: float) -> Viseme:
        """The mouth at ``time_s``; closed before the beginning and after the end."""
        index = bisect_right(self.mouth, time_s, key=lambda moment: moment.start_s) - 1
        return self.mouth[index].viseme if index >= 0 and time_s < self.duration_s else Viseme.CLOSED


class SpeechEngine(Protocol):
    """A speech synthesis. One thread at a time."""

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        """``text`` in ``language`` (a tag such as ``en`` or ``fr``), spoken in ``manner`` as far as it can. Raises
        SpeechError."""
        ...
