"""Two bands, split about ``CROSSOVER_HZ``: enough for what walls, air, mouths and doors do to sound.

The low band is a first-order low-pass, the high band what is left, so the two always add up to the whole, and whatever
is done to them leaves the delays between microphones alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

CROSSOVER_HZ = 2000.0
BAND_COUNT = 2
#: What air takes, dB per metre at 500 Hz and 6 kHz, 20 degrees Celsius, 50 % humidity (ISO 9613-1).
AIR_DB_PER_M = np.array([0.003, 0.06])

Samples = NDArray[np.float32]


def join(low: Samples, high: Samples, rate: int) -> Samples:
    """The sound with the low band of ``low`` and the high band of ``high``; last axis time."""
    b, a = low_pass(rate)
    joined: Samples = (high + lfilter(b, a, low - high, axis=-1)).astype(np.float32)
    return joined


def low_pass(rate: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The low band's filter, numerator and denominator, float32 so that it keeps float32 sound so."""
    warped = math.tan(math.pi * CROSSOVER_HZ / rate)
    b0, a1 = warped / (1 + warped), (warped - 1) / (1 + warped)
    return np.array([b0, b0], dtype=np.float32), np.array([1.0, a1], dtype=np.float32)


def split_power(samples: Samples, rate: int) -> NDArray[np.float64]:
    """Mean squares of ``samples``' (..., N) low and high bands: (..., 2)."""
    b, a = low_pass(rate)
    low = lfilter(b, a, samples, axis=-1)
    return np.stack([np.mean(low**2, axis=-1), np.mean((samples - low) ** 2, axis=-1)], axis=-1)
