"""Steered response power: the microphones' agreement on sound from a direction, by their cross-correlations, and its
maxima."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND, arrivals, search_grid, tangents

_SMALL = 1e-12
#: Greatest distance (rad) of a maximum from its start, at each refinement.
_LONGEST_STEP = float(np.radians(4.0))
_AROUND = np.array([-1, 0, 1])[:, None, None]


def lag_transform(frequencies: NDArray[np.floating], lags_s: NDArray[np.floating]) -> NDArray[np.float32]:
    """The matrix (2 B, W) that makes the real and imaginary parts (2 B,) of a cross spectrum at ``frequencies`` (B,) Hz
    a correlation at ``lags_s`` (W,), as one product of reals; phases that agree at a lag add up to 1."""
    turns = np.exp(2j * np.pi * frequencies[:, None] * lags_s)
    return np.ascontiguousarray(np.vstack([turns.real, -turns.imag]) / len(frequencies), np.float32)


class SteeredResponse:
    """Tables of one ``array``; no state. Responses are sums over its P pairs of their correlations, each at most 1.

    ``rate`` (Hz) of the samples; ``frequencies`` (B,) Hz of the cross spectra; ``range_m``: assumed distance of
    sources. ``grid`` (G, 3): directions of the search, as :func:`search_grid`.
    """

    def __init__(
        self,
        array: MicrophoneArray,
        rate: int,
        frequencies: NDArray[np.float64],
        *,
        points: int,
        lowest_deg: float,
        range_m: float,
    ) -> None:
        self._array = array
        self._rate = rate
        self._range_m = range_m
        self.grid = search_grid(array, points, lowest_deg)
        lags = self._lags(self.grid)
        longest = int(np.ceil(np.abs(lags).max())) + 2
        self._to_lags = lag_transform(frequencies, np.arange(-longest, longest + 1) / rate)
        self._rows = np.arange(len(array.first)) * (2 * longest + 1) + longest
        self._cells = np.ascontiguousarray((np.rint(lags).astype(np.int64) + self._rows).T)
        self._omega = (2 * np.pi / rate * frequencies).astype(np.float32)
        self._across = -(array.offsets[array.first] - array.offsets[array.second]).T * (rate / SPEED_OF_SOUND)

    def correlation(self, cross: NDArray[np.complex64]) -> NDArray[np.float32]:
        """Correlations (P * W,) over lags of cross spectra (P, B)."""
        return np.asarray((np.hstack([cross.real, cross.imag]) @ self._to_lags).reshape(-1))

    def on_grid(self, correlation: NDArray[np.float32]) -> NDArray[np.float32]:
        """Responses (G,) at the directions of the grid."""
        return np.asarray(correlation.take(self._cells, mode="clip").sum(axis=0))

    def steering(self, directions: NDArray[np.float64]) -> NDArray[np.complex64]:
        """Phase factors that align sound from each of ``directions`` (K, 3) at all microphones: (K, M, B)."""
        array = self._array
        delays = arrivals(array.offsets, directions, self._range_m, array.body_m) * self._rate
        angles = delays[:, :, None].astype(np.float32) * self._omega
        # Sines and cosines of reals are several times as fast as complex exponentials.
        steering = np.empty(angles.shape, np.complex64)
        np.cos(angles, out=steering.real)
        np.sin(angles, out=steering.imag)
        return steering

    def climb(
        self, correlation: NDArray[np.float32], directions: NDArray[np.float64], rounds: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Maxima near ``directions`` (K, 3), by ``rounds`` of Newton's method, and their mean responses of a pair, in
        [0, 1]."""
        for turn in range(rounds + 1):
            lags = self._lags(directions)
            nearest = np.rint(lags)
            cells = nearest.astype(np.int64) + self._rows
            before, at, after = correlation.take(cells + _AROUND)
            off = lags - nearest
            half = (after - before) * 0.5
            bend = after - at - at + before
            if turn == rounds:
                return directions, np.clip((at + off * (half + 0.5 * off * bend)).mean(axis=1), 0, 1)
            basis = tangents(directions)
            motion = basis @ self._across  # (K, 2, P): samples per radian
            gradient = (motion @ (half + off * bend)[:, :, None])[:, :, 0]
            curving = (motion * np.minimum(bend, 0)[:, None]) @ motion.transpose(0, 2, 1)
            directions = _ahead(directions, basis, _newton_step(gradient, curving))
        raise AssertionError("unreachable")

    def _lags(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Delays (samples) of sound from ``directions`` (G, 3), first of each pair minus second: (G, P)."""
        delays = arrivals(self._array.offsets, directions, self._range_m, self._array.body_m) * self._rate
        return np.asarray(delays[:, self._array.first] - delays[:, self._array.second])


def _newton_step(gradient: NDArray[np.float64], curving: NDArray[np.float64]) -> NDArray[np.float64]:
    """Steps (K, 2) to maxima by slopes (K, 2) and curvatures (K, 2, 2), made negative definite, damped and limited."""
    xx, xy, yy = curving[:, 0, 0], curving[:, 0, 1], curving[:, 1, 1]
    damping = 0.05 * (xx + yy) - _SMALL
    xx, yy = xx + damping, yy + damping
    across, along = gradient[:, 0], gradient[:, 1]
    steps = np.stack([xy * along - yy * across, xy * across - xx * along], axis=1) / (xx * yy - xy * xy)[:, None]
    length = np.sqrt((steps * steps).sum(axis=1))
    return np.asarray(steps * np.minimum(1, _LONGEST_STEP / np.maximum(length, _SMALL))[:, None])


def _ahead(
    directions: NDArray[np.float64], basis: NDArray[np.float64], steps: NDArray[np.float64]
) -> NDArray[np.float64]:
    moved = directions + (steps[:, None] @ basis)[:, 0]
    return np.asarray(moved / np.sqrt((moved * moved).sum(axis=1, keepdims=True)))
