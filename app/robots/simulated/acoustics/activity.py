"""Activity of a sound: louder than its own pauses, in steps of 10 ms."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

ACTIVITY_S = 0.01
_GAP = 4
"""Greatest number of steps of an ignored pause."""


def activity(samples: NDArray[np.float32], rate: int, below_db: float = 30.0) -> NDArray[np.bool_]:
    """For each 10 ms of ``samples`` (N,), whether it is within ``below_db`` of the loudest, or in a gap under 50 ms."""
    power = np.mean(pieces(samples, rate).astype(np.float64) ** 2, axis=1)
    active: NDArray[np.bool_] = (power > power.max(initial=0.0) * 10 ** (-below_db / 10)) & (power > 0)
    at = np.flatnonzero(active)
    for before, after in itertools.pairwise(at):
        if after - before <= _GAP + 1:
            active[before:after] = True
    return active


def pieces(samples: NDArray[np.float32], rate: int) -> NDArray[np.float32]:
    """``samples`` cut into rows of 10 ms, the last filled up with silence."""
    size = round(ACTIVITY_S * rate)
    return np.pad(samples, (0, -samples.size % size)).reshape(-1, size)
