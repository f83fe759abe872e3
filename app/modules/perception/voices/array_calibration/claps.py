"""Claps in the sound of several microphones, found block by block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Length of a hop (s), by which powers are measured.
HOP_S = 0.001
#: Hops of sound kept of a clap before its onset and after it.
BEFORE, AFTER = 50, 250
#: Hops over which the background is measured, and the least before a clap can be found.
_BACKGROUND, _LEAST_BACKGROUND = 1000, 100
#: Hops looked at with one background.
_TOGETHER = 20
#: Least power over the background (15 dB), and over the mean of the hops from 12 to 4 before (12 dB).
_LOUD, _STEEP = 30.0, 16.0
_EARLIER = (12, 4)
#: Least power of the loudest 5 hops at the onset over the mean from 100 to 200 hops later: 10 dB.
_SHORT = 10.0
_LEAST_POWER = 1e-11
#: A clap is loudest about 1 kHz; powers are of the sound's slope over this time (s), which leaves out rumble and hiss.
_SLOPE_S = 1 / 6000
#: A sample from here on is at full scale: the limit of the microphone or its amplifier.
_FULL = 0.997


def slope_length(rate: int) -> int:
    """Samples of each of the two means whose difference :func:`slopes` is."""
    return max(1, round(rate * _SLOPE_S))


def slopes(sound: NDArray[np.floating], rate: int) -> NDArray[np.float64]:
    """The slope of ``sound`` (N, M): the difference of two means that follow each other, (N - 2 slope_length, M). It
    passes best what is about 2.5 kHz; row i ends with sample i + 2 slope_length."""
    length = slope_length(rate)
    sums = np.cumsum(np.pad(sound, ((1, 0), (0, 0))), axis=0, dtype=np.float64)
    means = (sums[length:] - sums[:-length]) / length
    return np.asarray((means[length:] - means[:-length])[1:])


@dataclass(frozen=True, slots=True, eq=False)
class Clap:
    """One clap: ``sound`` (N, M) float32, full scale 1, at ``rate`` (Hz).

    Its onset is in the hop (1 ms) that begins at sample ``onset``, ``at_s`` seconds after the sound's begin.
    ``clipped``: whether a sample reached full scale.
    """

    at_s: float
    sound: NDArray[np.float32]
    rate: int
    onset: int
    clipped: bool


class ClapDetector:
    """Finds claps: sounds 15 dB over the background that rise within milliseconds and do not last, at a third of the
    microphones and two at least: a body between them shades the others, and one alone may have a loose contact.

    Other sudden sounds pass, too; they do no harm, as they come from one place, and loud ones are as good as claps.
    ``microphones``: number of channels; ``rate`` in Hz.
    """

    def __init__(self, rate: int, microphones: int) -> None:
        self._rate = rate
        self._hop = max(1, round(rate * HOP_S))
        self._sound = np.zeros((0, microphones), np.float32)
        self._powers = np.zeros((0, microphones))
        #: Samples before the first one kept, and the next hop kept that is looked at.
        self._before = self._next = 0

    def process(self, block: NDArray[np.int16]) -> list[Clap]:
        """Take the next samples (N, M) int16; returns the claps that are complete: a quarter of a second later."""
        self._sound = np.concatenate([self._sound, block.astype(np.float32) / 32768])
        self._measure()
        found = []
        while (onset := self._onset()) is not None:
            found.append(self._clap(onset))
            self._next = onset + AFTER
        self._forget()
        return found

    def restart(self, samples: int = 0) -> None:
        """The next block does not follow the last: ``samples`` were lost between."""
        self._before += len(self._sound) + samples
        self._sound, self._powers, self._next = self._sound[:0], self._powers[:0], 0

    def _measure(self) -> None:
        known = len(self._powers) * self._hop
        whole = (len(self._sound) - known) // self._hop
        if whole:
            lead = 2 * slope_length(self._rate)
            new = self._sound[max(0, known - lead) : known + whole * self._hop]
            filtered = slopes(np.pad(new, ((lead - min(known, lead), 0), (0, 0)), "edge"), self._rate)
            powers = (filtered.reshape(whole, self._hop, -1) ** 2).mean(axis=1)
            self._powers = np.concatenate([self._powers, np.maximum(powers, _LEAST_POWER)])

    def _onset(self) -> int | None:
        """The next hop with a clap's onset; None if none is complete."""
        self._next = max(self._next, _LEAST_BACKGROUND)
        while (end := min(self._next + _TOGETHER, len(self._powers) - AFTER)) > self._next:
            begin = self._next
            background = np.median(self._powers[max(0, begin - _BACKGROUND) : begin], axis=0)
            hops = np.arange(begin, end)
            now = self._powers[hops]
            early, late = _EARLIER
            past = np.mean([self._powers[hops - back] for back in range(late, early)], axis=0)
            sudden = (_of_a_third(now / background) > _LOUD) & (_of_a_third(now / past) > _STEEP)
            for hop in hops[sudden].tolist():
                if self._ends_soon(hop):
                    return int(hop)
            self._next = end
        return None

    def _ends_soon(self, hop: int) -> bool:
        loudest = np.max([self._powers[begin : begin + 5].mean(axis=0) for begin in range(hop, hop + 6)], axis=0)
        later = self._powers[hop + 100 : hop + 200].mean(axis=0)
        return bool(_of_a_third((loudest / later)[None])[0] > _SHORT)

    def _clap(self, hop: int) -> Clap:
        first = (hop - BEFORE) * self._hop
        sound = self._sound[first : (hop + AFTER) * self._hop].copy()
        at_s = (self._before + hop * self._hop) / self._rate
        return Clap(at_s, sound, self._rate, BEFORE * self._hop, bool(np.abs(sound).max() >= _FULL))

    def _forget(self) -> None:
        spare = min(self._next, len(self._powers)) - _BACKGROUND
        if spare > _BACKGROUND:
            self._before += spare * self._hop
            self._sound, self._powers = self._sound[spare * self._hop :], self._powers[spare:]
            self._next -= spare


def _of_a_third(ratios: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a third of the microphones, and at least two, reach or exceed: (F,) of ``ratios`` (F, M)."""
    count = ratios.shape[1]
    at_least = min(count, max(2, round(count / 3)))
    return np.asarray(np.sort(ratios, axis=1)[:, count - at_least])
