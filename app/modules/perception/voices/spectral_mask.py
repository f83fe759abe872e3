"""Spectral mask: weights of frequencies by their level above background and reverberation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Bias of the minimum of the smoothed power below the mean (minimum statistics).
_BIAS = 1.6
#: Factor over the background's minimum up to which a frame's power is background alone; the same for smoothed power.
_ALONE, _ALONE_SMOOTH = 8.0, 3.2
_SMOOTHING_S = 0.05
_WINDOW_S = 1.0
_TINY = 1e-14


class SpectralMask:
    """Weights frequencies by their level above background and reverberation.

    Background: the minimum of the smoothed power over the last one to two seconds (minimum statistics, Martin 2001).
    Reverberation: ``tail`` times the mean power of the last ``tail_s``; it follows loud sound, so direct sound exceeds
    it at onsets. No weight is below ``floor``, which is that of digital silence.

    Of the last frame: ``background`` (B,) float32: upper bound of the background's share of the power; ``quiet`` (B,)
    bool: whether only background sounded; ``settled``: whether the first second is over.
    """

    def __init__(self, bins: int, hop_s: float, tail: float, tail_s: float, floor: float) -> None:
        self._tail = tail
        self._floor = floor
        self._keep = np.float32(np.exp(-hop_s / _SMOOTHING_S))
        self._keep_tail = np.float32(np.exp(-hop_s / tail_s))
        self._window = max(1, round(_WINDOW_S / hop_s))
        self._bins = bins
        self.reset()

    def reset(self) -> None:
        """Discard the past."""
        self._count = 0
        zeros = np.zeros(self._bins, np.float32)
        self._smooth, self._room, self._lowest, self._lowest_now = zeros, zeros, zeros, zeros
        self.background = zeros
        self.quiet = np.zeros(self._bins, np.bool_)

    @property
    def settled(self) -> bool:
        """Whether the minimum covers at least a second."""
        return self._count > self._window

    def weigh(self, power: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weights (B,) in [0, 1] of the next frame's ``power`` (B,)."""
        if not self._count:
            self._smooth = self._room = self._lowest = self._lowest_now = power
        self._count += 1
        self._smooth = power + self._keep * (self._smooth - power)
        if self._count % self._window == 0:
            self._lowest, self._lowest_now = self._lowest_now, self._smooth
        self._lowest_now = np.minimum(self._lowest_now, self._smooth)
        self._lowest = np.minimum(self._lowest, self._smooth)
        unwanted = np.float32(_BIAS) * self._lowest + np.float32(self._tail) * self._room
        self.background = np.minimum(np.float32(1), np.float32(_ALONE) * self._lowest / (power + np.float32(_TINY)))
        self.quiet = self._smooth < np.float32(_ALONE_SMOOTH) * self._lowest
        self._room = power + self._keep_tail * (self._room - power)
        clear = 1 - (unwanted + np.float32(_TINY)) / (power + np.float32(_TINY))
        return np.asarray(np.maximum(np.float32(self._floor), clear), np.float32)
