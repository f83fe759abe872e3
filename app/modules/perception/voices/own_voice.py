"""The robot's own voice, removed from its microphones: an acoustic echo canceller.

A partitioned-block frequency-domain Kalman filter (Enzner and Vary 2006; Kuech, Mabande and Enzner 2014) per
microphone: it needs no double-talk detector, and leaves level and phase of other sounds as they are, so that their
directions stay. What was learnt is kept between sentences. Pure; knows no clock and no channel.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from app.modules.perception.voices.residual_echo import ResidualEcho

Sound = NDArray[np.float32]
#: Samples, and the number of the first of them.
Numbered = tuple[int, NDArray[np.int16]]

#: Length of a block (s), and number of blocks that the echo may last: 0.19 s of direct sound and early reflections.
BLOCK_S = 0.032
PARTITIONS = 6
#: Of the echo path, a share that stays from block to block; the rest is drift that the filter expects.
_PERSISTENCE = np.float32(0.9995)
#: Variances before the first block: of the echo path, and of what is no echo (of full scale, per frequency).
_PATH_VARIANCE, _REST_VARIANCE = 1.0, 1e-2
#: Smoothing of the latter from block to block.
_SMOOTHING = np.float32(0.8)
#: Below this level (of full scale) the loudspeaker counts as silent: nothing is learnt.
_SILENT = 1e-4
#: The filter is warm once it has removed this (dB) over some blocks, or has learnt for so long (s).
_WARM_DB, _WARM_S, _WARM_BLOCKS = 20.0, 3.0, 8
#: Fall (dB/s) of the echo's envelope: that of late reverberation, which the filter does not reach.
_FALL_DB_S = 62.0
#: Another sound is let through from the block on at which it has the first share of the frequencies, until so long (s)
#: after the last at which it had the second.
_OPENING, _STAYING, _HOLD_S = 0.05, 0.015, 0.25
#: Power below which the envelope is over.
_OVER = 1e-8


class EchoCanceller:
    """Removes one reference from ``channels`` microphones, block by block of ``block`` samples; at most ``partitions``
    blocks of echo. ``echo_power``: mean square of the echo in the last block."""

    def __init__(self, channels: int, block: int, partitions: int = PARTITIONS) -> None:
        bins = block + 1
        self.block = block
        self._past = np.zeros(block, np.float32)
        self._reference = np.zeros((partitions, bins), np.complex64)
        #: Blocks for which the last that was not silent is among the reference.
        self._lasts = 0
        self._path = np.zeros((channels, partitions, bins), np.complex64)
        self._path_variance = np.full((channels, partitions, bins), _PATH_VARIANCE, np.float32)
        self._rest_variance = np.full((channels, bins), _REST_VARIANCE, np.float32)
        self.echo_power = 0.0

    @property
    def sounds(self) -> bool:
        """Whether the echo of past blocks still lasts."""
        return self._lasts > 0

    def process(self, reference: Sound, microphones: Sound, used: Sequence[int] | None = None) -> Sound:
        """``microphones`` (M, block) without the echo of ``reference`` (block,), both of full scale 1.

        ``used``: the numbers of the M microphones; None: all.
        """
        n, rows = self.block, slice(None) if used is None else np.asarray(used)
        self._reference = np.roll(self._reference, 1, axis=0)
        self._reference[0] = fft.rfft(np.concatenate([self._past, reference]))
        self._past = reference
        # Of each block the second half is in the spectrum of the block after it.
        self._lasts = len(self._reference) + 1 if reference.any() else max(0, self._lasts - 1)
        X, W = self._reference, self._path[rows]
        echo = fft.irfft(np.einsum("mpf,pf->mf", W, X), 2 * n, axis=-1)[:, n:]
        self.echo_power = float(np.mean(echo * echo))
        error = microphones - echo
        if float(np.abs(reference).max()) >= _SILENT:
            self._learn(error, W, rows)
        return np.asarray(error, np.float32)

    def forget_past(self) -> None:
        """The next block does not follow the last; what was learnt of the echo path is kept."""
        self._past[:] = 0
        self._reference[:] = 0
        self._lasts = 0

    def _learn(self, error: Sound, W: NDArray[np.complex64], rows: slice | NDArray[np.int_]) -> None:
        n, X, P = self.block, self._reference, self._path_variance[rows]
        E = fft.rfft(np.concatenate([np.zeros_like(error), error], axis=1), axis=-1)
        XX = X.real**2 + X.imag**2
        S = _SMOOTHING * self._rest_variance[rows] + (1 - _SMOOTHING) * (E.real**2 + E.imag**2)
        self._rest_variance[rows] = S
        gain = P / (np.einsum("mpf,pf->mf", P, XX) + 2 * S + np.float32(1e-8))[:, None]
        step = fft.irfft(gain * X.conj() * E[:, None], 2 * n, axis=-1)
        step[..., n:] = 0  # the echo path is causal, and no longer than a block
        W = _PERSISTENCE * (W + fft.rfft(step, axis=-1))
        self._path[rows] = W
        drift = (1 - _PERSISTENCE**2) * (W.real**2 + W.imag**2)
        self._path_variance[rows] = _PERSISTENCE**2 * (1 - np.float32(0.5) * gain * XX) * P + drift + np.float32(1e-9)


class OwnVoiceFilter:
    """Frames of microphones in, frames without what the loudspeaker played out.

    While the loudspeaker is silent frames pass at once as they are. While it plays they come out in blocks, at most
    ``BLOCK_S`` later; all microphones are muted together unless something else is heard: what the canceller leaves of
    the echo (beginnings, late reverberation) would be taken for a voice in a quiet room. ``rate`` (Hz) of both; the
    numbers of their samples are of one count.
    """

    def __init__(self, channels: int, rate: int) -> None:
        self._canceller = EchoCanceller(channels, round(BLOCK_S * rate))
        self._residual = ResidualEcho(self._canceller.block, rate)
        self._block_s = self._canceller.block / rate
        self._played: deque[tuple[int, Sound]] = deque()
        self._waiting = np.zeros((0, channels), np.int16)
        self._first = 0
        self._cold = True
        self._learnt_s = 0.0
        self._powers: deque[tuple[float, float]] = deque(maxlen=_WARM_BLOCKS)
        self._envelope = 0.0
        self._open_s = 0.0
        self._gain = np.float32(1)

    @property
    def needed(self) -> bool:
        """Whether there is echo to be removed: else, without ``played``, :meth:`process` returns its argument."""
        return bool(len(self._waiting)) or self._echoes

    @property
    def _echoes(self) -> bool:
        return bool(self._played or self._canceller.sounds or self._envelope > _OVER)

    def process(
        self,
        first_sample: int,
        samples: NDArray[np.int16],
        played: Iterable[Numbered] = (),
        used: Sequence[int] | None = None,
    ) -> Numbered:
        """The next samples (N, C) and the number of the first, following those returned before; ``samples`` (M, C) are
        the next of the microphones, from number ``first_sample`` on.

        ``played``: what the loudspeaker plays, (K,) from its number on. Only the columns ``used`` are processed (None:
        all). N is 0 while a block is incomplete.
        """
        for begin, sound in played:
            self._played.append((begin, sound.astype(np.float32) / np.float32(32768)))
        if not self.needed:
            return first_sample, samples
        if not len(self._waiting):
            self._first = first_sample
        first = self._first
        self._waiting = np.concatenate([self._waiting, samples])
        block, done = self._canceller.block, []
        while len(self._waiting) >= block:
            done.append(self._clean(self._waiting[:block], used))
            self._waiting = self._waiting[block:]
            self._first += block
        if not self._echoes:
            done.append(self._waiting)
            self._waiting = self._waiting[:0]
            self._gain = np.float32(1)
            self._residual.forget_past()
        return first, np.concatenate(done) if done else samples[:0]

    def reset(self) -> None:
        """The next samples do not follow the last."""
        self._waiting = self._waiting[:0]
        self._played.clear()
        self._canceller.forget_past()
        self._residual.forget_past()
        self._envelope = 0.0

    def _clean(self, samples: NDArray[np.int16], used: Sequence[int] | None) -> NDArray[np.int16]:
        reference = self._reference(self._first, len(samples))
        columns = list(range(samples.shape[1])) if used is None else list(used)
        sound = np.ascontiguousarray(samples[:, columns].T).astype(np.float32) / np.float32(32768)
        clean = self._canceller.process(reference, sound, used)
        if self._cold and float(np.abs(reference).max()) >= _SILENT:
            self._judge(float(np.mean(sound * sound)), float(np.mean(clean * clean)))
        gain = self._next_gain(self._residual.others(sound - clean, clean))
        # Closing is sudden: the first block of a sentence would be heard through a ramp.
        ramp = np.linspace(min(self._gain, gain), gain, len(samples), dtype=np.float32)
        self._gain = gain
        out = samples.copy()
        out[:, columns] = np.clip(np.rint((clean * ramp).T * 32768), -32768, 32767).astype(np.int16)
        return out

    def _judge(self, before: float, after: float) -> None:
        """Whether the filter removes enough by now: the echo's power is ``before``, what is left of it ``after``."""
        self._learnt_s += self._block_s
        self._powers.append((before, after))
        full = len(self._powers) == _WARM_BLOCKS
        removed = sum(b for b, _ in self._powers) > _ratio(_WARM_DB) * sum(a for _, a in self._powers)
        self._cold = not (full and removed) and self._learnt_s < _WARM_S

    def _next_gain(self, others: float) -> np.float32:
        """The gain after a block at which another sound has the share ``others`` of the frequencies."""
        self._envelope = max(self._canceller.echo_power, self._envelope * _ratio(-_FALL_DB_S * self._block_s))
        another = others > (_STAYING if self._open_s > 0 else _OPENING)
        self._open_s = _HOLD_S if another else self._open_s - self._block_s
        if self._cold and self._canceller.sounds:
            return np.float32(0)
        # Whole silence: what is merely soft is located as well, for levels do not count.
        return np.float32(self._open_s > 0 or self._envelope <= _OVER)

    def _reference(self, first: int, count: int) -> Sound:
        """What was played as number ``first`` and the next; forgets what is older."""
        reference = np.zeros(count, np.float32)
        for begin, samples in self._played:
            a, b = max(begin, first), min(begin + len(samples), first + count)
            if a < b:
                reference[a - first : b - first] = samples[a - begin : b - begin]
        while self._played and self._played[0][0] + len(self._played[0][1]) <= first + count:
            self._played.popleft()
        return reference


def _ratio(db: float) -> float:
    return float(10 ** (db / 10))
