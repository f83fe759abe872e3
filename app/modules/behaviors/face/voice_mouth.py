"""The mouth while a voice is played of which only the sound is known: it opens with the level. Pure; times in s."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

_WINDOW_S = 0.04
"""The level is a mean over so long: several periods of a deep voice."""
_GAP_S = 0.15
"""A gap between two frames that is shorter is the network's: the voice has not ended."""
_FORGETTING_DB_PER_S = 3.0
"""By so much the loudest level of late falls: an operator who speaks lower opens the mouth as far after a while."""
_SILENCE_DB = -50.0
"""dB of full scale: nothing below it opens the mouth."""
#: Below the loudest level of late by up to so many dB, the mouth has this viseme; by more it is closed.
_SHAPES = ((3.5, "open"), (9.0, "mid"), (18.0, "narrow"))


class VoiceMouth:
    """Visemes of the frames of a voice, each played once those before it were."""

    def __init__(self) -> None:
        #: Begin, end and mean square (full scale 1) of frames that are played or will be.
        self._frames: deque[tuple[float, float, float]] = deque(maxlen=200)
        self._until = -math.inf
        self._loudest_db = -math.inf
        self._time = -math.inf

    def take(self, samples: NDArray[np.int16], rate: int, now: float) -> None:
        """A frame ``samples`` (N, C) at ``rate`` per second came at ``now``."""
        if len(samples):
            begin = max(now, self._until)
            self._until = begin + len(samples) / rate
            self._frames.append((begin, self._until, float(np.square(samples / 32768.0).mean())))

    def viseme(self, now: float) -> str | None:
        """The mouth at ``now``, not falling; None while no voice is played."""
        while self._frames and self._frames[0][1] <= now - _WINDOW_S:
            self._frames.popleft()
        if now - self._until > _GAP_S:
            return None
        played = [power for begin, _, power in self._frames if begin <= now]
        level_db = 10.0 * math.log10(max(sum(played) / max(len(played), 1), 1e-12))
        forgotten_db = _FORGETTING_DB_PER_S * (now - self._time) if math.isfinite(self._time) else 0.0
        self._loudest_db, self._time = max(level_db, self._loudest_db - forgotten_db), now
        if level_db < _SILENCE_DB:
            return "closed"
        return next((name for below, name in _SHAPES if level_db >= self._loudest_db - below), "closed")
