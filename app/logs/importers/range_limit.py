"""Estimates the range from which a laser's readings mean "nothing seen", from the readings alone.

A laser without a return reports a code near its greatest range, or, if a program converted codes to metres or corrected
them, several values spread over a metre: a peak of the histogram at the far end, in any direction, with almost no
readings around it. A far wall is seen in a few directions, and at many distances.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Width of a bin of the histogram (m), its upper end (m), and the number of sectors of rays.
_BIN_M = 0.1
_MOST_M = 80.0
_SECTORS = 8
#: The limit is so far (m) before the pile: readings are written in centimetres.
_MARGIN_M = 0.005
#: No pile nearer than this (m) is looked for: rooms are as large.
_NEAREST_M = 15.0
#: A pile has this share of all readings at least, ...
_SHARE = 2e-3
#: ... is no wider than this (m), ...
_WIDEST_M = 1.6
#: ... has at most this share of its readings beyond it, ...
_BEYOND = 0.02
#: ... is this many times as dense as the readings before it, from this share of its range on, ...
_DENSER = 20.0
_BEFORE = 0.8
#: ... and has readings in this many sectors: a wall is seen in fewer at one distance.
_LEAST_SECTORS = 4
#: A sector has the pile, too, where its share there is at least this share of the pile's.
_SECTOR_SHARE = 0.1


class FarEnd:
    """A histogram of readings: :meth:`add` sweeps, then :meth:`limit`."""

    def __init__(self) -> None:
        self._counts = np.zeros((_SECTORS, round(_MOST_M / _BIN_M)), np.int64)

    def add(self, ranges: NDArray[np.floating]) -> None:
        """Count ``ranges`` (N,) or (S, N) m, in the order of their rays; those that are no distance do not count."""
        ranges = np.atleast_2d(ranges)
        sectors = np.broadcast_to(np.arange(ranges.shape[1]) * _SECTORS // max(ranges.shape[1], 1), ranges.shape)
        with np.errstate(invalid="ignore"):
            counted = (ranges > 0.0) & (ranges < _MOST_M - _BIN_M)
        bins = sectors[counted] * self._counts.shape[1] + (ranges[counted] / _BIN_M).astype(np.int64)
        self._counts += np.bincount(bins, minlength=self._counts.size).reshape(self._counts.shape)

    def limit(self) -> float | None:
        """Just below the least range (m) of the pile at the far end; None where there is none."""
        counts = self._counts.sum(axis=0)
        total = int(counts.sum())
        if not total:
            return None
        widest = round(_WIDEST_M / _BIN_M)
        # Of the stretches as wide as a pile may be, with next to nothing beyond, the fullest.
        sums = np.convolve(counts, np.ones(widest, np.int64), "valid")
        beyond = total - np.cumsum(counts)[widest - 1 :]
        sums[beyond > _BEYOND * sums] = 0
        sums[: round(_NEAREST_M / _BIN_M)] = 0
        first = int(np.argmax(sums))
        pile = int(sums[first])
        if pile < _SHARE * total:
            return None
        before = counts[int(_BEFORE * first) : first].mean()
        # The peak's edges: where its density falls to that before it.
        dense = np.flatnonzero(counts[first : first + widest] > max(_DENSER / 2 * before, _SHARE * pile))
        if not dense.size:
            return None
        low, high = first + int(dense[0]), first + int(dense[-1]) + 1
        inside = counts[low:high].mean()
        before = counts[int(_BEFORE * low) : low - 1].mean()
        if inside < _DENSER * before:
            return None
        by_sector = self._counts[:, low:high].sum(axis=1)
        if (by_sector >= _SECTOR_SHARE * pile / _SECTORS).sum() < _LEAST_SECTORS:
            return None
        return low * _BIN_M - _MARGIN_M
