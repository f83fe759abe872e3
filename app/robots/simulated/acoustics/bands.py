"""Two frequency bands, split about ``CROSSOVER_HZ``: enough for absorption by walls and air, doors and mouths.

The low band is a first-order low-pass, the high band the rest, so their sum is the original, and processing of the
bands preserves the delays between microphones.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

CROSSOVER_HZ = 2000.0
TAPS = 36
#: Absorption of air, dB per metre at 500 Hz and 6 kHz, 20 degrees Celsius, 50 % humidity (ISO 9613-1).
AIR_DB_PER_M = np.array([0.003, 0.06])

Samples = NDArray[np.float32]


def join(low: Samples, high: Samples, rate: int) -> Samples:
    """The sound (..., N) with the low band of ``low`` and the high band of ``high``, both (..., N)."""
    apart = low - high
    size = fast_length(apart.shape[-1] + TAPS)
    filtered = np.fft.irfft(np.fft.rfft(apart, size) * np.fft.rfft(low_pass(rate), size), size)
    joined: Samples = high + filtered[..., : apart.shape[-1]].astype(np.float32)
    return joined


@lru_cache(maxsize=4)
def low_pass(rate: int) -> Samples:
    """The low band's filter, (TAPS,) float32: a first-order low-pass until it is 80 dB down, 1 at 0 Hz."""
    response = np.exp(-2 * math.pi * CROSSOVER_HZ / rate * np.arange(TAPS))
    return np.asarray(response / response.sum(), dtype=np.float32)


def fast_length(length: int) -> int:
    """A length with a fast FFT, not shorter."""
    return min((1 << (length - 1).bit_length()), 3 << (max(length - 1, 3) // 3).bit_length())
