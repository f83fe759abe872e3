"""Onset agreement: the onset of a sound arrives from its source, reverberation follows (precedence effect)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_TINY = 1e-14


class Onsets:
    """Agreement of onsets, and of all sound, with directions.

    The onset power of a frequency is the rise of its power from one frame to the next. At an onset direct sound arrives
    before any reflection, so onsets agree best with the source's direction; an echo's direction agrees with onsets no
    better than with all sound.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard the past."""
        self._before: NDArray[np.float32] | None = None

    def update(self, phases: NDArray[np.complex64], powers: NDArray[np.float32], weights: NDArray[np.float32]) -> None:
        """Take the next frames: ``phases`` (F, M, B) of absolute value 1; their ``powers`` and ``weights`` (F, B)."""
        before = powers[:1] if self._before is None else self._before
        self._before = powers[-1:]
        rise = np.maximum(0, 1 - np.concatenate([before, powers[:-1]]) / (powers + np.float32(_TINY)))
        self._phases = phases
        self._weights = np.stack([(weights * rise).ravel(), weights.ravel()])

    def agreement(self, steering: NDArray[np.complex64]) -> NDArray[np.float64]:
        """Agreement of the last frames with beams ``steering`` (K, M, B): (K, 4), of onsets, of all sound, and the
        greatest possible value of both.

        The agreement of a beam is 1 where all microphones agree on its direction and 0 on average where they do not; it
        is summed over frames and frequencies by their weights.
        """
        beams = (self._phases[None] * steering[:, None]).sum(axis=2)
        count = self._phases.shape[1]
        alike = (beams.real**2 + beams.imag**2 - count) / (count * (count - 1))
        sums = alike.reshape(len(steering), -1) @ self._weights.T
        most = np.broadcast_to(self._weights.sum(axis=1), sums.shape)
        return np.concatenate([sums, most], axis=1, dtype=np.float64)
