"""Check of a microphone array's geometry by sound alone.

Sound that reaches microphones i and j at times t_i and t_j gives a peak of their cross-correlation at the lag t_i -
t_j. All pairs agree on M - 1 such differences, wherever the microphones are: around any three the lags add up to zero.
Two figures of one loud moment, both means over the pairs of correlations with phase transform, are compared:

- *agreed*: the maximum over all sets of arrival times, without any geometry;
- *explained*: the maximum over directions, each with its arrival times by the configured positions.

Their ratio is near 1 where the positions are right, in any room, with noise and with several talkers, since both are
taken of the same correlations. With channels in another order, or positions of another scale, no direction has the
measured arrival times. An order that is a rotation or a mirror image of the array keeps all distances: its directions
are turned or mirrored, and sound alone cannot reveal it. Detection rates of wrong arrays are in docs/voices.md,
measured by ``benchmarks/voice_arrays.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steered_response import lag_transform
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND, arrivals, search_grid, tangents

#: Step of the lags (s): a quarter of a period at 7 kHz is 3.4 steps.
LAG_STEP_S = 1 / 96_000
#: Range of the arrival times, as a multiple of the array's size: the configured size may be too small.
_WIDER = 2.5
#: ... and at most this share of a frame, beyond which frames have too little in common.
_SHARE_OF_FRAME = 0.3
#: Microphones whose pairs initialize the search for arrival times.
_STARTS = 4
_SWEEPS = 3
_POINTS = 1200
_LOWEST_DEG = -90.0
#: Refinements around the best point of the grid, in turn (rad).
_CLOSER = (0.05, 0.025, 0.012, 0.006)
_RANGE_M = 1.8
#: Least agreement of a moment that counts; with few microphones noise alone agrees somewhat.
_AGREED, _AGREED_OF_FEW = 0.08, 0.15
#: Least number of moments for a verdict, and greatest number evaluated.
LEAST_MOMENTS, MOST_MOMENTS = 12, 60
#: Least explained share for correct positions, by the array's size (m): small arrays differ little between microphones,
#: so that wrong positions explain much.
_LEAST_SHARES, _SIZES_M = (0.9, 0.7), (0.1, 0.2)


@dataclass(frozen=True, slots=True)
class ArrayAgreement:
    """Result of one moment: ``agreed``, the agreement for any arrival times, and ``explained``, for those of the best
    direction; 0 <= explained <= agreed <= 1."""

    agreed: float
    explained: float


class ArrayCheck:
    """Compares sound with the microphones' positions until there are enough moments.

    ``frequencies`` (B,) Hz of the cross spectra; ``frame_s``: length of the transformed frames (s). ``moments``: number
    of evaluated moments, at most :data:`MOST_MOMENTS`.
    """

    def __init__(self, array: MicrophoneArray, frequencies: NDArray[np.float64], frame_s: float) -> None:
        self._array = array
        size_m = float(np.linalg.norm(array.positions[array.first] - array.positions[array.second], axis=1).max())
        size_s = size_m / SPEED_OF_SOUND
        #: Least explained share for correct positions.
        self.least_share = float(np.interp(size_m, _SIZES_M, _LEAST_SHARES))
        self._longest = int(min(max(_WIDER * size_s, size_s + 0.0003), _SHARE_OF_FRAME * frame_s) / LAG_STEP_S) + 1
        self._width = 2 * self._longest + 1
        times = np.arange(-self._longest, self._longest + 1) * LAG_STEP_S
        self._to_lags = lag_transform(frequencies, times)
        self._grid = search_grid(array, _POINTS, _LOWEST_DEG)
        self._rows = np.arange(len(array.first)) * self._width + self._longest
        self._cells = self._cells_of(self._grid)
        count = len(array)
        self._pair = np.full((count, count), -1)
        self._pair[array.first, array.second] = np.arange(len(array.first))
        self._least = _AGREED + _AGREED_OF_FEW / count
        self._agreed_in_all = self._explained_in_all = 0.0
        self.moments = 0

    @property
    def done(self) -> bool:
        """Whether there are enough moments; further ones change nothing."""
        return self.moments >= MOST_MOMENTS

    @property
    def share(self) -> float:
        """The explained share of the agreement, in [0, 1]; 1 before the first moment."""
        return self._explained_in_all / self._agreed_in_all if self._agreed_in_all else 1.0

    @property
    def failed(self) -> bool:
        """Whether the positions fail to explain the sound, in enough moments for a verdict."""
        return self.moments >= LEAST_MOMENTS and self.share < self.least_share

    def update(self, cross: NDArray[np.complex64]) -> None:
        """Evaluate one moment as :meth:`agreement` does; no effect once :attr:`done`."""
        if self.done:
            return
        moment = self.agreement(cross)
        if moment.agreed >= self._least:
            self.moments += 1
            self._agreed_in_all += moment.agreed
            self._explained_in_all += moment.explained

    def agreement(self, cross: NDArray[np.complex64]) -> ArrayAgreement:
        """Agreement of one moment, by its cross spectra (P, B): of the first of each pair times the conjugate of the
        second's, each absolute value at most 1."""
        correlation = np.asarray(np.hstack([cross.real, cross.imag]) @ self._to_lags)
        delays, explained = self._best_direction(correlation)
        agreed = max(explained, *(self._agreed(correlation, start) for start in self._starts(correlation, delays)))
        pairs = len(cross)
        return ArrayAgreement(max(0.0, agreed) / pairs, max(0.0, explained) / pairs)

    # --- by the positions ---

    def _delays(self, directions: NDArray[np.float64]) -> NDArray[np.int64]:
        """Arrival times (G, M) in steps of the lags."""
        array = self._array
        late = arrivals(array.offsets, directions, _RANGE_M, array.body_m)
        return np.asarray(np.rint(late / LAG_STEP_S), np.int64)

    def _cells_of(self, directions: NDArray[np.float64]) -> NDArray[np.int64]:
        delays = self._delays(directions)
        lags = delays[:, self._array.first] - delays[:, self._array.second]
        return np.asarray(np.clip(lags, -self._longest, self._longest) + self._rows)

    def _best_direction(self, correlation: NDArray[np.float32]) -> tuple[NDArray[np.int64], float]:
        flat = correlation.reshape(-1)
        response = flat[self._cells].sum(axis=1)
        best = int(response.argmax())
        direction, most = self._grid[best], float(response[best])
        for step in _CLOSER:
            across, along = tangents(direction[None])[0]
            around = np.array([direction + step * (a * across + b * along) for a in (-1, 0, 1) for b in (-1, 0, 1)])
            around /= np.linalg.norm(around, axis=1, keepdims=True)
            response = flat[self._cells_of(around)].sum(axis=1)
            best = int(response.argmax())
            direction, most = around[best], max(most, float(response[best]))
        return self._delays(direction[None])[0], most

    # --- by no geometry ---

    def _starts(self, correlation: NDArray[np.float32], delays: NDArray[np.int64]) -> list[NDArray[np.int64]]:
        """Initial arrival times (M,): of the best direction, and by the pairs of some microphones each."""
        count = len(self._array)
        peaks = np.zeros((count, count), np.int64)
        heights = np.zeros((count, count), np.float32)
        lags = correlation.argmax(axis=1) - self._longest
        first, second = self._array.first, self._array.second
        peaks[second, first], peaks[first, second] = lags, -lags
        heights[first, second] = heights[second, first] = correlation.max(axis=1)
        clearest = np.argsort(-heights.sum(axis=0))[:_STARTS]
        return [delays, *(peaks[:, microphone] for microphone in clearest.tolist())]

    def _agreed(self, correlation: NDArray[np.float32], start: NDArray[np.int64]) -> float:
        """The sum over pairs at the arrival times that coordinate ascent, microphone by microphone, reaches from
        ``start``."""
        count = len(self._array)
        delays = start.copy()
        for _ in range(_SWEEPS):
            before = delays.copy()
            for moved in range(count):
                self._move(correlation, delays, moved)
            if (delays == before).all():
                break
        lags = delays[self._array.first] - delays[self._array.second]
        if np.abs(lags).max() > self._longest:
            return 0.0
        return float(correlation.reshape(-1)[lags + self._rows].sum())

    def _move(self, correlation: NDArray[np.float32], delays: NDArray[np.int64], moved: int) -> None:
        """Set one microphone's arrival time to the one that agrees best with all others."""
        others = [(other, int(delay)) for other, delay in enumerate(delays.tolist()) if other != moved]
        low = max(delay for _, delay in others) - self._longest
        high = min(delay for _, delay in others) + self._longest
        if low > high:
            return
        total = np.zeros(high - low + 1, np.float32)
        for other, delay in others:
            if moved < other:
                begin = low - delay + self._longest
                total += correlation[self._pair[moved, other], begin : begin + len(total)]
            else:
                # The lag of (other, moved) decreases as the moved arrival time increases.
                begin = delay - high + self._longest
                total += correlation[self._pair[other, moved], begin : begin + len(total)][::-1]
        delays[moved] = low + int(total.argmax())
