"""When a clap arrives at each microphone, to a small part of a sample.

For each pair of microphones the lag of the direct sound is the peak of the generalized cross-correlation with phase
transform (C. H. Knapp and G. C. Carter, "The generalized correlation method for estimation of time delay", IEEE TASSP
24, 1976), each frequency weighted by its signal-to-noise ratio. The spectrum is padded, and a parabola through the peak
gives fractions of the step. One arrival time for each microphone is fitted to the lags of all pairs; pairs that
contradict the others (an echo taken for the direct sound) lose their weight.

The first estimate is of one window for all microphones. Then each one's window is laid around its own arrival, so that
all hold the same few milliseconds of the direct sound, and what reflections bring later stays outside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.claps import Clap, slope_length, slopes

#: Band (Hz) of the correlation; below, windows so short hold no period.
_LOWEST_HZ, _HIGHEST_HZ = 400.0, 12_000.0
#: Window around the arrival: from so long before to so long after it (s).
_BEFORE_S, _AFTER_S = 0.0012, 0.002
#: Lag between microphones' own windows that is searched (s).
_NEAR_S = 0.00012
_PADDED = 16
#: Contradiction (s) at which a pair's weight is half.
_CONTRADICTION_S = 15e-6
_FITS = 8
#: The direct sound begins where the sum of the scaled slopes exceeds this share of its maximum.
_BEGINS = 0.2
#: The reverberation from which levels are taken (s after the onset).
_TAIL_S = (0.03, 0.18)


@dataclass(frozen=True, slots=True, eq=False)
class Arrivals:
    """What one clap is at M microphones.

    ``times`` (M,) s, about their mean. ``agreement`` (M,): mean correlation of each with the others at these times, 1
    if their direct sounds are alike, about 0 for an unrelated sound; ``reversed`` (M,) bool: whether it is alike with
    the opposite sign. Powers (M,) of full scale 1, each without the noise's: ``direct``, of the window around the
    arrival, ``tail``, of the reverberation, which is alike for all directions; ``noise``, before the clap.
    """

    times: NDArray[np.float64]
    agreement: NDArray[np.float64]
    reversed: NDArray[np.bool_]
    direct: NDArray[np.float64]
    tail: NDArray[np.float64]
    noise: NDArray[np.float64]


def arrivals_of(clap: Clap, longest_s: float) -> Arrivals:
    """The arrivals of ``clap``; no two microphones are farther apart than sound travels in ``longest_s``."""
    rate, sound = clap.rate, clap.sound.astype(np.float64)
    count = sound.shape[1]
    quiet = sound[: round(0.8 * clap.onset)]
    begin = _begin(sound, clap.onset, rate, longest_s)
    before, after = round(_BEFORE_S * rate), round(_AFTER_S * rate)
    cut = _windows(sound, np.full(count, begin - before), before + after + round(longest_s * rate))
    lags, heights = lags_of(cut, quiet, rate, longest_s)
    late = fit(lags, heights, count)
    starts = begin + np.rint((late - late.min()) * rate).astype(np.int64)
    for _ in range(2):
        cut = _windows(sound, starts - before, before + after)
        lags, heights = lags_of(cut, quiet, rate, _NEAR_S)
        late = fit(lags, heights, count)
        late -= late.mean()
        times = starts / rate + late
        starts = starts + np.rint(late * rate).astype(np.int64)
    noise = (quiet**2).mean(axis=0)
    return Arrivals(
        times - times.mean(),
        *_agreement(heights, count),
        direct=np.maximum((_windows(sound, starts - before, before + after) ** 2).mean(axis=0) - noise, 0),
        tail=np.maximum(_tail_power(sound, quiet, clap.onset, rate), 0),
        noise=noise,
    )


def lags_of(
    sound: NDArray[np.float64], quiet: NDArray[np.float64], rate: int, longest_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lags (P,) s by which the first of each pair of microphones hears later than the second, at most ``longest_s``;
    and the heights of the correlations' peaks (P,), from -1 to 1. ``sound`` (N, M), with noise as in ``quiet``.

    The peak is that of the absolute value: of a microphone with reversed polarity it is negative."""
    size = 1 << (2 * len(sound) - 1).bit_length()
    spectra = np.fft.rfft(sound, size, axis=0)
    frequencies = np.fft.rfftfreq(size, 1 / rate)
    noise = (np.abs(np.fft.rfft(quiet * np.hanning(len(quiet))[:, None], size, axis=0)) ** 2).mean(axis=1)
    noise *= len(sound) / max(1.0, 0.375 * len(quiet))
    power = np.median(np.abs(spectra) ** 2, axis=1)
    smooth = np.hanning(9) / np.hanning(9).sum()
    noise, power = np.convolve(noise, smooth, "same"), np.convolve(power, smooth, "same")
    weights = np.maximum(0, 1 - 2 * noise / (power + 1e-20))
    weights[(frequencies < _LOWEST_HZ) | (frequencies > min(_HIGHEST_HZ, 0.42 * rate))] = 0
    weights /= max(weights.sum(), 1e-12)
    first, second = np.triu_indices(sound.shape[1], 1)
    cross = spectra[:, first] * spectra[:, second].conj()
    cross *= (weights / 2)[:, None] / (np.abs(cross) + 1e-20)
    correlation = np.fft.irfft(cross, size * _PADDED, axis=0) * (size * _PADDED)
    step_s = 1 / (rate * _PADDED)
    reach = max(2, round(longest_s / step_s))
    near = np.concatenate([correlation[-reach:], correlation[: reach + 1]])
    peak = np.clip(np.abs(near).argmax(axis=0), 1, 2 * reach - 1)
    pairs = np.arange(near.shape[1])
    left, middle, right = (near[peak + shift, pairs] for shift in (-1, 0, 1))
    bend = np.sign(middle) * (left - 2 * middle + right)
    aside = np.where(bend < 0, 0.5 * np.sign(middle) * (left - right) / np.where(bend < 0, bend, 1), 0)
    return (peak - reach + np.clip(aside, -0.5, 0.5)) * step_s, middle


def fit(lags: NDArray[np.float64], heights: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Arrival times (M,) s, of mean 0, to the ``lags`` (P,) s of all pairs; pairs that contradict the others lose their
    weight (a Cauchy weight of their residuals), so that some wrong lags do no harm."""
    first, second = np.triu_indices(count, 1)
    table = np.zeros((count, count))
    table[first, second], table[second, first] = lags, -lags
    trust = heights**2 + 1e-9

    def contradictions(times: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(lags - (times[first] - times[second]))

    def misfit(times: NDArray[np.float64]) -> float:
        return float((trust * np.log1p((contradictions(times) / _CONTRADICTION_S) ** 2)).sum())

    # Each microphone's lags to all others are a guess of their own; the one that most pairs confirm is refined.
    times = min((table[:, reference] for reference in range(count)), key=misfit)
    for _ in range(_FITS):
        weights = trust / (1 + (contradictions(times) / _CONTRADICTION_S) ** 2)
        # The Laplacian of the graph of pairs; the added constant fixes the mean.
        normal = np.full((count, count), weights.sum() / count**2)
        np.add.at(normal, (first, second), -weights)
        np.add.at(normal, (second, first), -weights)
        np.add.at(normal, (first, first), weights)
        np.add.at(normal, (second, second), weights)
        right = np.zeros(count)
        np.add.at(right, first, weights * lags)
        np.add.at(right, second, -weights * lags)
        times = np.linalg.solve(normal, right)
    return np.asarray(times - times.mean())


def _begin(sound: NDArray[np.float64], onset: int, rate: int, longest_s: float) -> int:
    """The sample at which the direct sound begins at the first microphone that it reaches."""
    late = 2 * slope_length(rate)
    rises = np.abs(slopes(sound[: onset + round((0.005 + longest_s) * rate)], rate))
    low = max(late, onset - round(0.002 * rate)) - late
    together = (rises / (rises[low:].max(axis=0) + 1e-9)).sum(axis=1)
    noise = together[: round(0.8 * onset) - late].max(initial=0.0)
    loud = together[low:] > max(_BEGINS * together[low:].max(), 1.3 * noise)
    return low + late // 2 + int(loud.argmax())


def _windows(sound: NDArray[np.float64], starts: NDArray[np.int64], length: int) -> NDArray[np.float64]:
    """The sound of each microphone from its own start (M,) on: (length, M), faded in and out; zero outside."""
    rows = starts[None] + np.arange(length)[:, None]
    inside = (rows >= 0) & (rows < len(sound))
    cut = np.where(inside, sound[np.clip(rows, 0, len(sound) - 1), np.arange(sound.shape[1])], 0)
    fade_in = max(1, length // 8)
    fade_out = max(1, length // 3)
    shape = np.ones(length)
    shape[:fade_in] = np.sin(0.5 * np.pi * (np.arange(fade_in) + 0.5) / fade_in) ** 2
    shape[-fade_out:] = np.cos(0.5 * np.pi * (np.arange(fade_out) + 0.5) / fade_out) ** 2
    return np.asarray(cut * shape[:, None])


def _agreement(heights: NDArray[np.float64], count: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Agreement (M,) of each microphone with the others, and whether its sign is not that of most."""
    first, second = np.triu_indices(count, 1)
    table = np.zeros((count, count))
    table[first, second] = table[second, first] = heights
    # The main eigenvector has a sign for each microphone such that most pairs agree.
    signs = np.where(np.linalg.eigh(table)[1][:, -1] < 0, -1, 1)
    signs = signs if signs.sum() >= 0 else -signs
    agreed = signs * (table @ signs) / (count - 1)
    return np.asarray(agreed), np.asarray(signs < 0)


def _tail_power(sound: NDArray[np.float64], quiet: NDArray[np.float64], onset: int, rate: int) -> NDArray[np.float64]:
    """Power of the reverberation in the correlation's band (M,), less that of the noise."""
    begin, end = (onset + round(late * rate) for late in _TAIL_S)
    return _band_power(sound[begin:end], rate) - _band_power(quiet, rate)


def _band_power(sound: NDArray[np.float64], rate: int) -> NDArray[np.float64]:
    spectra = np.abs(np.fft.rfft(sound, axis=0)) ** 2
    frequencies = np.fft.rfftfreq(len(sound), 1 / rate)
    band = (frequencies >= _LOWEST_HZ) & (frequencies <= min(_HIGHEST_HZ, 0.42 * rate))
    return np.asarray(2 * spectra[band].sum(axis=0) / len(sound) ** 2)
