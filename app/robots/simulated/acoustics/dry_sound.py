"""Dry sounds with travel time: a sampled sound, read with the delay of its path and so with its Doppler shift."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float32]
_TAPS, _PHASES = 16, 512


class DrySound(Protocol):
    """Sound as it leaves its source: amplitude at 1 m, full scale 1, numbered in samples since it began."""

    def read(self, start: int, count: int) -> Samples:
        """``count`` samples from number ``start`` on; zeros before its beginning and after its end."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledSound:
    """``samples`` (N,) float32, played once or, ``loop``, for ever."""

    samples: Samples
    loop: bool = False

    def read(self, start: int, count: int) -> Samples:
        size = self.samples.size
        if self.loop and size:
            out: Samples = self.samples[np.arange(max(start, 0), start + count) % size]
            return out if start >= 0 else np.concatenate([np.zeros(min(count, -start), np.float32), out])
        out = np.zeros(count, dtype=np.float32)
        first, last = max(start, 0), min(start + count, size)
        if last > first:
            out[first - start : last - start] = self.samples[first:last]
        return out


def ramp(begin: float, end: float, count: int) -> Samples:
    """``count`` evenly spaced numbers from ``begin`` to ``end``, without ``end``."""
    return np.float32(begin) + np.float32((end - begin) / count) * _numbers(count)


@lru_cache(maxsize=8)
def _numbers(count: int) -> Samples:
    return np.arange(count, dtype=np.float32)


def _sinc_table() -> NDArray[np.float32]:
    offsets = np.arange(_TAPS) - (_TAPS // 2 - 1)
    table = np.empty((_PHASES + 1, _TAPS), dtype=np.float64)
    for phase in range(_PHASES + 1):
        x = offsets - phase / _PHASES
        table[phase] = np.sinc(x) * np.i0(8.0 * np.sqrt(np.maximum(1 - (2 * x / _TAPS) ** 2, 0))) / np.i0(8.0)
        table[phase] /= table[phase].sum()
    return table.astype(np.float32)


_SINC = _sinc_table()


def read_between(dry: DrySound, first: float, last: float, count: int) -> Samples:
    """``count`` samples of ``dry`` at places (in samples) that run evenly from ``first`` up to, without, ``last``."""
    begin = math.floor(first)
    if abs(last - count - first) < 1e-3:  # without motion
        phase_ = round((first - begin) * _PHASES)
        section = dry.read(begin - (_TAPS // 2 - 1), count + _TAPS - 1)
        return np.convolve(section, _SINC[phase_][::-1], mode="valid")
    places = first + (last - first) / count * np.arange(count)
    whole = np.floor(places).astype(np.int64)
    phase = np.rint((places - whole) * _PHASES).astype(np.int64)
    base = int(whole.min()) - (_TAPS // 2 - 1)
    section = dry.read(base, int(whole.max()) - base + _TAPS // 2 + 1)
    windows = np.lib.stride_tricks.sliding_window_view(section, _TAPS)[whole - (_TAPS // 2 - 1) - base]
    between: Samples = np.einsum("nt,nt->n", windows, _SINC[phase])
    return between
