"""The robot's loudspeaker as a sound source: frames queue for at most half a second and play in order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.acoustics.dry_sound import SampledSound, read_between

Samples = NDArray[np.float32]
MOST_S = 0.5
START_S = 0.03
"""Buffered sound (s) before playback starts, since frames arrive unevenly."""
_AHEAD = 10
KEPT = 1024


class LoudspeakerSource:
    """A ``Dry`` sound read onward. ``rate`` is that of the microphones."""

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._their_rate = rate
        self._waiting: Samples = np.zeros(0, dtype=np.float32)
        self._at = 0.0
        self._playing = False
        self._played: Samples = np.zeros(KEPT, dtype=np.float32)
        self._end = 0
        self.dropped = 0
        """Samples dropped because more than half a second waited."""

    def play(self, samples: NDArray[np.int16], rate: int) -> None:
        """Queue ``samples`` (N,) of ``rate``; beyond half a second the oldest are dropped."""
        if rate != self._their_rate:
            self._their_rate, self._waiting, self._at = rate, np.zeros(0, dtype=np.float32), 0.0
        self._waiting = np.concatenate([self._waiting, samples.astype(np.float32) / 32768.0])
        surplus = self._waiting.size - round(MOST_S * rate) - _AHEAD
        if surplus > 0:
            self._waiting = self._waiting[surplus:]
            self._at = 0.0
            self.dropped += surplus

    @property
    def waiting_s(self) -> float:
        """Queued sound (s)."""
        return max(0.0, (self._waiting.size - self._at) / self._their_rate)

    def read(self, start: int, count: int) -> Samples:
        """Samples ``start`` to ``start + count`` of the playback: queued samples are played when a number is read
        first.

        The last ``KEPT`` samples can be read again; older ones are silence.
        """
        if start - self._end > KEPT:
            self._played, self._end = np.zeros(KEPT, dtype=np.float32), start
        fresh = start + count - self._end
        if fresh > 0:
            self._played = np.concatenate([self._played, self._take(fresh)])[-KEPT - count :]
            self._end += fresh
        begin = start - (self._end - self._played.size)
        known = self._played[max(begin, 0) : begin + count]
        return np.concatenate([np.zeros(count - known.size, dtype=np.float32), known])

    def _take(self, count: int) -> Samples:
        step = self._their_rate / self._rate
        if not self._playing:
            self._playing = self.waiting_s >= START_S
        if not self._playing:
            return np.zeros(count, dtype=np.float32)
        out = read_between(SampledSound(self._waiting), self._at, self._at + count * step, count)
        self._at += count * step
        done = max(0, int(self._at) - _AHEAD)
        self._waiting, self._at = self._waiting[done:], self._at - done
        if self._at >= self._waiting.size:
            self._playing, self._waiting, self._at = False, np.zeros(0, dtype=np.float32), 0.0
        return out
