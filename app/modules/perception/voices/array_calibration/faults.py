"""Faults of microphones that claps show, and how sensitive each microphone is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.arrival_times import Arrivals

#: A microphone is silent if its claps are so much weaker than the median microphone's (dB).
_SILENT_DB = -30.0
#: ... and noisy if its noise is so much stronger.
_NOISY_DB = 12.0
#: Least agreement, as a share of the median microphone's.
_RELATED = 0.5
#: Channels carry the same sound if arrival times differ by less (s) in most claps though microphones are apart (m).
_SAME_S, _APART_M, _MOST = 1e-6, 0.01, 0.8
#: Least power of a reverberation from which gains are taken, as a multiple of the noise, which is subtracted.
_CLEAR = 0.2
_TINY = 1e-13


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong with a channel, in words after its number ("" for nothing); ``silences``: whether its arrival times
    say nothing."""

    words: str = ""
    silences: bool = False


def faults_of(heard: Sequence[Arrivals], positions: NDArray[np.float64]) -> list[Fault]:
    """The fault of each of M channels, by the claps ``heard``; ``positions`` (M, 3) m as configured."""
    direct = np.array([one.direct for one in heard]) + _TINY
    levels = np.median(_decibels(direct / np.median(direct, axis=1, keepdims=True)), axis=0)
    noise = _decibels(np.median([one.noise for one in heard], axis=0) + _TINY)
    agreement = np.median([one.agreement for one in heard], axis=0)
    reversed_ = np.mean([one.reversed for one in heard], axis=0)
    same = _same(np.array([one.times for one in heard]), positions)
    faults = []
    for channel in range(len(positions)):
        louder = noise[channel] - np.median(noise)
        fault = Fault()
        if direct[:, channel].max() <= 2 * _TINY:
            fault = Fault("hears none of the claps", True)
        elif levels[channel] < _SILENT_DB:
            fault = Fault(f"hears next to nothing: {-levels[channel]:.0f} dB below the median microphone", True)
        elif agreement[channel] < _RELATED * np.median(agreement):
            fault = Fault("hears something else than the other microphones, or noise alone", True)
        elif same[channel] >= 0:
            fault = Fault(f"carries the same sound as channel {same[channel]}", True)
        elif reversed_[channel] > _MOST:
            fault = Fault("has reversed polarity, which spoils directions: exchange its two wires")
        elif louder > _NOISY_DB:
            fault = Fault(f"is noisy: {louder:.0f} dB more noise than the median microphone")
        faults.append(fault)
    return faults


def _same(times: NDArray[np.float64], positions: NDArray[np.float64]) -> list[int]:
    """For each channel the earlier one that carries the same sound, or -1."""
    alike = (np.abs(times[:, :, None] - times[:, None]) < _SAME_S).mean(axis=0) > _MOST
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2) > _APART_M
    found = []
    for channel in range(len(positions)):
        earlier = np.flatnonzero(alike[channel, :channel] & apart[channel, :channel])
        found.append(int(earlier[0]) if len(earlier) else -1)
    return found


def gains_db(heard: Sequence[Arrivals], ways: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sensitivity of each microphone (M,) in dB relative to the median one, and its standard deviation (dB).

    It is taken of the reverberation after each clap, which comes from all directions alike; where there is none, as
    outdoors, of the direct sound by its ways (K, M) m. NaN for a channel without sound.
    """
    tails, noise = np.array([one.tail for one in heard]), np.array([one.noise for one in heard])
    clear = np.median(tails, axis=1) > _CLEAR * np.median(noise, axis=1)
    if clear.sum() >= max(3, len(heard) / 2):
        powers = tails[clear]
    else:
        powers = np.array([one.direct for one in heard]) * ways**2
    with np.errstate(invalid="ignore", divide="ignore"):
        levels = np.where(powers > _TINY, _decibels(powers), np.nan)
    heard_at_all = np.isfinite(levels).mean(axis=0) > 0.5
    levels = levels - np.nanmedian(levels[:, heard_at_all], axis=1, keepdims=True)
    gains = np.where(heard_at_all, np.nanmedian(np.where(heard_at_all, levels, 0.0), axis=0), np.nan)
    spread = np.nanmedian(np.abs(np.where(heard_at_all, levels - gains, 0.0)), axis=0)
    # Of a median: 1.25 standard deviations over the root of the number; these are 1.48 median deviations.
    deviations = np.where(heard_at_all, 1.25 * 1.48 * spread / np.sqrt(len(powers)), np.nan)
    return np.asarray(gains - np.nanmedian(gains)), np.asarray(deviations)


def _decibels(power: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(10 * np.log10(power))
