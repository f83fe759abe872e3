"""Automatic gain control with a limiter: brings sources at any distance to one level."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Sound = NDArray[np.float32]
_SILENCE = 1e-12


@dataclass(frozen=True, slots=True)
class GainSettings:
    """``target_db``: root mean square (dB of full scale) of a source's louder moments at the output. ``most_db``:
    greatest gain. ``release_db_s``: decay of the tracked level (dB/s). ``attack``: weight of a louder piece in the
    tracked level, in [0, 1]. ``peak``: limit of the samples."""

    target_db: float = -20.0
    most_db: float = 40.0
    release_db_s: float = 6.0
    attack: float = 0.5
    peak: float = 0.95


class AutomaticGain:
    """Tracks the level of one source's louder moments, so that pauses between words are not amplified to the level of
    words."""

    def __init__(self, rate: int, settings: GainSettings = GainSettings()) -> None:
        self._target = 10 ** (settings.target_db / 20)
        self._most = 10 ** (settings.most_db / 20)
        self._decay = settings.release_db_s / rate / 10
        self._attack = settings.attack
        self._peak = settings.peak
        #: Gain rises within 4 ms and falls at once, since a sudden sound must not clip.
        self._rise = np.linspace(0, 1, rate // 250, dtype=np.float32)
        self._loud: float | None = None
        self._gain = math.inf

    def apply(self, piece: Sound) -> tuple[Sound, float]:
        """The next ``piece`` (N,) at the target level, and its level below the louder moments (dB, >= 0)."""
        power = float(np.dot(piece, piece)) / len(piece)
        if self._loud is None:
            self._loud = power
        elif power > self._loud:
            self._loud += self._attack * (power - self._loud)
        else:
            self._loud = max(power, self._loud * 10 ** (-self._decay * len(piece)))
        highest = max(float(piece.max()), -float(piece.min()))
        gain = min(
            self._target / math.sqrt(self._loud + _SILENCE), self._most, self._peak / max(highest, math.sqrt(_SILENCE))
        )
        out = piece * np.float32(gain)
        if gain > self._gain:
            rise = self._rise[: len(piece)]
            before = np.float32(self._gain / gain)
            out[: len(rise)] *= before + (1 - before) * rise
        self._gain = gain
        below = 10 * math.log10((self._loud + _SILENCE) / (power + _SILENCE))
        return out, max(0.0, below)
