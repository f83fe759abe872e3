"""Delay-and-sum beamformer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import arrivals

Sound = NDArray[np.float32]


class DelayAndSum:
    """Beams toward any directions, block by block, with delays of whole samples.

    ``range_m``: assumed distance of sources. The output is ``latency`` samples late.
    """

    def __init__(self, array: MicrophoneArray, rate: int, range_m: float = 1.8) -> None:
        self._array = array
        self._rate = rate
        self._range_m = range_m
        # The greatest delay is of sound from behind the middle, around the body if there is one; the least is its
        # negative.
        behind = -array.offsets / np.maximum(np.linalg.norm(array.offsets, axis=1, keepdims=True), 1e-6)
        latest = float(arrivals(array.offsets, behind, range_m, array.body_m).max())
        self.latency = int(np.ceil(latest * rate)) + 1
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        self._sound = np.zeros((len(self._array), 2 * self.latency), np.float32)

    def update(self, samples: Sound) -> None:
        """Take the next samples (N, M), columns as the array's positions."""
        self._sound = np.concatenate([self._sound[:, -2 * self.latency :], samples.T], axis=1)

    def beam(self, direction: NDArray[np.float64]) -> Sound:
        """Sound from ``direction`` (3,) in the last block: (N,), the mean over the aligned microphones."""
        delays = arrivals(self._array.offsets, direction[None], self._range_m, self._array.body_m)[0] * self._rate
        begins = np.rint(delays).astype(int) + self.latency
        length = self._sound.shape[1] - 2 * self.latency
        total = np.zeros(length, np.float32)
        for microphone, begin in enumerate(begins.tolist()):
            total += self._sound[microphone, begin : begin + length]
        return total / np.float32(len(self._array))
