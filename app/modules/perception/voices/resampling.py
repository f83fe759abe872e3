"""Sample-rate conversion, of a stream and of a whole sound."""

from __future__ import annotations

from math import gcd

import numpy as np
from numpy.typing import NDArray

Sound = NDArray[np.float32]


def low_pass(taps: int, cutoff: float, beta: float) -> NDArray[np.float64]:
    """A linear-phase FIR (taps,) that passes what is below ``cutoff`` (of half the sample rate), of Kaiser's window.

    As ``scipy.signal.firwin`` makes it, which takes a third of a second to import.
    """
    kernel = np.sinc(cutoff * (np.arange(taps) - (taps - 1) / 2)) * np.kaiser(taps, beta)
    return np.asarray(kernel / kernel.sum())


def resampled(sound: NDArray[np.float32], rate_in: int, rate_out: int) -> NDArray[np.float32]:
    """The whole of ``sound`` (N, C) at the new rate, by a polyphase filter and without delay.

    As ``scipy.signal.resample_poly`` makes it.
    """
    common = gcd(rate_in, rate_out)
    up, down = rate_out // common, rate_in // common
    if up == down:
        return sound
    half = 10 * max(up, down)
    kernel = low_pass(2 * half + 1, 1 / max(up, down), 5.0) * up
    taps = -(-len(kernel) // up)
    # Row p: the taps of outputs at p / up after an input sample, the newest input's first.
    phases = np.pad(kernel, (0, taps * up - len(kernel))).reshape(taps, up).T.astype(np.float32)
    padded = np.pad(sound, ((taps, half // up + 1), (0, 0)))
    out = np.zeros((-(-len(sound) * up // down), sound.shape[1]), np.float32)
    for number in range(min(up, len(out))):
        newest, phase = divmod(number * down + half, up)
        part = out[number::up]
        for age, tap in enumerate(phases[phase]):
            begin = taps + newest - age
            part += tap * padded[begin : begin + (len(part) - 1) * down + 1 : down]
    return out


class Resampler:
    """One channel from ``rate_in`` to ``rate_out`` samples a second, piece by piece, by a polyphase filter.

    A linear-phase FIR (Kaiser window, 60 dB) that passes what is below 0.85 of half the lower rate;
    ``delay_s``: how much later the sound comes out. Equal rates pass as they are.
    """

    def __init__(self, rate_in: int, rate_out: int, zeros: int = 12) -> None:
        self.rate_in = rate_in
        self._same = rate_in == rate_out
        common = gcd(rate_in, rate_out)
        self._up, self._down = rate_out // common, rate_in // common
        longer = max(self._up, self._down)
        taps = 2 * zeros * longer // self._up
        kernel = low_pass(taps * self._up, 0.93 / longer, 6.0) * self._up
        # Row p: the taps, last first, by which an output at p / up after an input sample is made.
        self._phases = np.ascontiguousarray(kernel.reshape(taps, self._up).T[:, ::-1], np.float32)
        self._taps = taps
        self.delay_s = 0.0 if self._same else (taps * self._up - 1) / 2 / (rate_in * self._up)
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        self._past = np.zeros(self._taps - 1, np.float32)
        self._due = 0

    def process(self, sound: Sound) -> Sound:
        """The next samples (N,) at the new rate."""
        if self._same:
            return sound
        whole = np.concatenate([self._past, sound])
        end = len(sound) * self._up
        instants = np.arange(self._due, end, self._down)
        self._due = int(instants[-1]) + self._down - end if len(instants) else self._due - end
        self._past = whole[len(sound) :]
        if not len(instants):
            return np.zeros(0, np.float32)
        windows = np.lib.stride_tricks.sliding_window_view(whole, self._taps)[instants // self._up]
        if self._up == 1:
            return np.asarray(windows @ self._phases[0], np.float32)
        return np.asarray(np.einsum("nt,nt->n", windows, self._phases[instants % self._up]), np.float32)
