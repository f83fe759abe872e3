"""One utterance heard by all microphones: where it comes from, and its sound with less noise.

When an utterance has ended all of it is known, so nothing is estimated on the way. With the covariances of the sound
during the utterance, S, and before it, N, at each frequency:

1. direction: steered response power with phase transform, S - N weighted by its share of S;
2. beam: minimum variance distortionless response, w = R⁻¹ a / aᴴ R⁻¹ a with R = N + λ tr(N)/M I. The loading λ is
   large: a beam that trusts N and the free field's steering vector a more loses the voice in a room that echoes;
3. Wiener filter of the beam's sound against wᴴ N w, by Ephraim and Malah's decision-directed estimate (1984), with a
   high floor: the noise that stays masks what the filter does to the voice, which recognizers mind more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import arrivals, search_grid

#: Rate (Hz) of the sound; samples per transform, and between two.
RATE, _FRAME, _HOP = 16_000, 512, 128
#: Frequencies (Hz) by which the direction is found, number of directions on the sphere, and their lowest elevation.
_BAND_HZ, _POINTS, _LOWEST_DEG = (200.0, 4500.0), 2000, -40.0
#: Cross-correlations are made at so many times the rate.
_FINE = 8
#: Assumed distance (m) of a talker.
_RANGE_M = 1.8
#: Weight of the frame before in the Wiener filter's estimate.
_BEFORE = 0.9
#: Least sound (s) before an utterance by which its noise is known.
LEAST_NOISE_S = 0.2
_TINY = 1e-12

Spectra = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class FocusedUtterance:
    """``samples`` (N,) float32 of the utterance at 16 kHz, and its ``direction`` (3,), a unit vector in the array's
    axes from its middle."""

    samples: NDArray[np.float32]
    direction: NDArray[np.float64]


class UtteranceBeam:
    """Hears utterances by the microphones of ``array``.

    ``loading``: λ of the beam; infinite: delay and sum. ``floor``: least gain of the Wiener filter; 1: none.
    """

    def __init__(self, array: MicrophoneArray, loading: float = 1.0, floor: float = 0.3) -> None:
        self.array = array
        self._loading = loading
        self._floor = floor
        self._window = np.sqrt(np.hanning(_FRAME + 1)[:-1])
        self._frequencies = np.fft.rfftfreq(_FRAME, 1 / RATE)
        low, high = _BAND_HZ
        self._in_band = (self._frequencies >= low) & (self._frequencies <= high)
        self._grid = search_grid(array, _POINTS, _LOWEST_DEG)
        self._delays = arrivals(array.offsets, self._grid, _RANGE_M, array.body_m)
        apart = self._delays[:, array.first] - self._delays[:, array.second]
        self._lags = np.rint(apart * RATE * _FINE).astype(int) % (_FINE * _FRAME)

    def focus(self, sound: NDArray[np.float32], noise: NDArray[np.float32]) -> FocusedUtterance:
        """The utterance ``sound`` (N, M), after the ``noise`` (K, M) before it, all in [-1, 1), columns as the array's.

        Noise of less than LEAST_NOISE_S is not used.
        """
        spectra = self._spectra(sound)
        heard = _covariance(spectra)
        known = len(noise) >= LEAST_NOISE_S * RATE
        rest = _covariance(self._spectra(noise)) if known else np.zeros_like(heard)
        best = int(np.argmax(self._response(heard, rest)))
        weights = self._weights(best, rest)
        beam = np.einsum("fm,fmt->ft", weights.conj(), spectra)
        if known:
            beam *= _wiener(
                np.abs(beam) ** 2, np.einsum("fm,fmn,fn->f", weights.conj(), rest, weights).real, self._floor
            )
        return FocusedUtterance(self._sound(beam, len(sound)), self._grid[best])

    def _response(self, heard: Spectra, rest: Spectra) -> NDArray[np.float64]:
        """Steered response power (G,) of the grid's directions."""
        crossed = (heard - rest)[:, self.array.first, self.array.second]
        share = np.maximum(0, 1 - _power(rest) / (_power(heard) + _TINY)) * self._in_band
        whitened = share[:, None] * crossed / (np.abs(crossed) + _TINY)
        # Cross-correlations of all pairs, looked up at the delays that each direction has between them.
        correlations = fft.irfft(whitened, _FINE * _FRAME, axis=0)
        return np.asarray(correlations[self._lags, np.arange(len(self.array.first))].sum(axis=1))

    def _weights(self, direction: int, rest: Spectra) -> Spectra:
        """Weights (F, M) of the beam toward a direction of the grid; delay and sum where the noise is not known."""
        count = len(self.array)
        steering = np.exp(-2j * np.pi * self._frequencies[:, None] * self._delays[direction])
        if math.isinf(self._loading):
            return np.asarray(steering / count)
        load = (self._loading * _power(rest) / count + _TINY)[:, None, None] * np.eye(count)
        turned = np.linalg.solve(rest + load, steering[:, :, None])[:, :, 0]
        return np.asarray(turned / np.einsum("fm,fm->f", steering.conj(), turned)[:, None])

    def _spectra(self, sound: NDArray[np.float32]) -> Spectra:
        """Spectra (F, M, T) of ``sound`` (N, M)."""
        padded = np.pad(sound.T.astype(np.float64), ((0, 0), (_FRAME - _HOP, _FRAME)))
        frames = np.lib.stride_tricks.sliding_window_view(padded, _FRAME, axis=1)[:, ::_HOP]
        return np.asarray(fft.rfft(frames * self._window, axis=-1).transpose(2, 0, 1))

    def _sound(self, beam: Spectra, length: int) -> NDArray[np.float32]:
        """Sound (length,) of spectra (F, T), by overlap-add."""
        frames = fft.irfft(beam.T, _FRAME, axis=-1) * self._window
        sound = np.zeros(len(frames) * _HOP + _FRAME)
        for number, frame in enumerate(frames):
            sound[number * _HOP : number * _HOP + _FRAME] += frame
        return np.asarray(sound[_FRAME - _HOP :][:length] * (2 * _HOP / _FRAME), np.float32)


def _covariance(spectra: Spectra) -> Spectra:
    """(F, M, M), the mean over time of spectra (F, M, T)."""
    return np.asarray(spectra @ spectra.conj().transpose(0, 2, 1) / spectra.shape[2])


def _power(covariance: Spectra) -> NDArray[np.float64]:
    """(F,), over all microphones."""
    return np.asarray(np.trace(covariance, axis1=1, axis2=2).real)


def _wiener(powers: NDArray[np.float64], noise: NDArray[np.float64], floor: float) -> NDArray[np.float64]:
    """Gains (F, T), ``floor`` at least, of a sound of ``powers`` (F, T) with noise of mean power ``noise`` (F,)."""
    gains = np.empty_like(powers)
    noise = noise + _TINY
    before = np.zeros_like(noise)
    for index, power in enumerate(powers.T):
        ratio = _BEFORE * before / noise + (1 - _BEFORE) * np.maximum(power / noise - 1, 0)
        gain = np.maximum(ratio / (1 + ratio), floor)
        gains[:, index] = gain
        before = gain * gain * power
    return gains
