"""Sounds made by rule from a seed: claps, knocks, doors, footsteps, an alarm, music, a fan; the library sets levels."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Samples = NDArray[np.float32]
Maker = Callable[[int, Generator], Samples]


def _decay(seconds: float, time_constant_s: float, rate: int) -> NDArray[np.float64]:
    times = np.arange(round(seconds * rate)) / rate
    decayed: NDArray[np.float64] = np.exp(-times / time_constant_s)
    return decayed


def _band(
    samples: NDArray[np.float64], low_hz: float, high_hz: float, rate: int, order: int = 2
) -> NDArray[np.float64]:
    """``order`` first-order high-passes and low-passes; nothing comes early."""
    size = 2 * samples.size
    f = np.fft.rfftfreq(size, 1 / rate)
    passed = (1j * f / low_hz) / (1 + 1j * f / low_hz) / (1 + 1j * f / high_hz)
    filtered: NDArray[np.float64] = np.fft.irfft(np.fft.rfft(samples, size) * passed**order, size)[: samples.size]
    return filtered


def _single(samples: NDArray[np.float64]) -> Samples:
    fade = min(240, samples.size // 4)
    samples[samples.size - fade :] *= np.linspace(1, 0, fade)
    return samples.astype(np.float32)


def clap(rate: int, rng: Generator) -> Samples:
    """Two hands: a burst of air whose hollow rings about 1 kHz (after L. Peltola and others, TASLP 15, 2007)."""
    noise = rng.standard_normal(round(0.12 * rate))
    hollow_hz = rng.uniform(700.0, 1500.0)
    burst = noise * _decay(0.12, rng.uniform(0.003, 0.006), rate)
    slap = _band(noise * _decay(0.12, 0.0015, rate), 1800, 9000, rate)
    return _single(_band(burst, 0.6 * hollow_hz, 1.8 * hollow_hz, rate, 1) + 0.5 * slap)


def knock(rate: int, rng: Generator) -> Samples:
    """Three knuckles on a wooden door."""
    out = np.zeros(round(0.9 * rate))
    at = 0.0
    for _ in range(3):
        one = np.zeros(round(0.2 * rate))
        times = np.arange(one.size) / rate
        for hz, tau in ((170, 0.035), (395, 0.022), (820, 0.012), (1650, 0.006)):
            one += (
                rng.uniform(0.6, 1.0)
                * np.sin(2 * math.pi * hz * rng.uniform(0.97, 1.03) * times)
                * np.exp(-times / tau)
            )
        one[: round(0.001 * rate)] *= np.linspace(0, 1, round(0.001 * rate))
        begin = round(at * rate)
        out[begin : begin + one.size] += rng.uniform(0.8, 1.0) * one
        at += rng.uniform(0.2, 0.26)
    return _single(out)


def door(rate: int, rng: Generator) -> Samples:
    """A door falling shut: the thud of the leaf, its panel's rattle, the latch."""
    out = np.zeros(round(0.7 * rate))
    thud = _band(rng.standard_normal(out.size) * _decay(0.7, 0.07, rate), 50, 220, rate)
    panel = _band(rng.standard_normal(out.size) * _decay(0.7, 0.04, rate), 300, 1400, rate)
    out += thud / np.abs(thud).max() + 0.5 * panel / np.abs(panel).max()
    for at in (0.0, rng.uniform(0.06, 0.1)):
        click = _band(rng.standard_normal(round(0.03 * rate)) * _decay(0.03, 0.002, rate), 1500, 7000, rate)
        begin = round(at * rate)
        out[begin : begin + click.size] += 0.5 * click / np.abs(click).max()
    return _single(out)


def step(rate: int, rng: Generator) -> Samples:
    """A heel, then the sole, on a hard floor."""
    out = np.zeros(round(0.28 * rate))
    heel = _band(rng.standard_normal(out.size) * _decay(0.28, 0.012, rate), 90, 900, rate, 1)
    out += heel / np.abs(heel).max()
    begin = round(rng.uniform(0.07, 0.1) * rate)
    sole = _band(rng.standard_normal(out.size - begin), 400, 3500, rate, 1)
    sole *= np.sin(math.pi * np.arange(sole.size) / sole.size) ** 2
    out[begin:] += 0.2 * sole / np.abs(sole).max()
    return _single(out)


def alarm(rate: int, rng: Generator) -> Samples:
    """A two-tone alarm, one second of it; goes on evenly when looped."""
    times = np.arange(rate) / rate
    tones = np.where(times < 0.5, 960, 770)
    phase = 2 * math.pi * np.cumsum(tones) / rate
    tone = sum(np.sin(n * phase) / n for n in (1, 2, 3, 5))
    return np.asarray(tone, dtype=np.float32)


def music(rate: int, rng: Generator) -> Samples:
    """Sixteen seconds of plucked strings in a pentatonic scale, over a slow bass."""
    beat_s = 0.5
    out = np.zeros(round((32 * beat_s + 2.0) * rate))
    scale = [0, 2, 4, 7, 9]
    place = 5
    for beat in range(32):
        if beat % 8 == 0:
            _pluck(
                out,
                beat * beat_s,
                hz=98.0 * 2 ** (scale[int(rng.integers(3))] / 12),
                seconds=1.6,
                loudness=0.8,
                rate=rate,
            )
        if rng.random() < 0.2:
            continue
        place = int(np.clip(place + rng.integers(-2, 3), 0, 9))
        hz = 261.63 * 2 ** (scale[place % 5] / 12 + place // 5)
        _pluck(out, beat * beat_s, hz=hz, seconds=0.7, loudness=rng.uniform(0.5, 0.9), rate=rate)
    whole = round(32 * beat_s * rate)
    out[: out.size - whole] += out[whole:]  # the last notes ring on into the beginning of the next turn
    return out[:whole].astype(np.float32)


def _pluck(out: NDArray[np.float64], at_s: float, hz: float, seconds: float, loudness: float, rate: int) -> None:
    begin = round(at_s * rate)
    times = np.arange(min(round(1.4 * rate), out.size - begin)) / rate
    note = sum(
        np.sin(2 * math.pi * n * hz * times) * np.exp(-times * (1 + 0.8 * n) / seconds) / n**1.3 for n in range(1, 6)
    )
    note[: round(0.004 * rate)] *= np.linspace(0, 1, round(0.004 * rate))
    out[begin : begin + times.size] += loudness * note


def fan(rate: int, rng: Generator) -> Samples:
    """Five seconds of a ventilator's rush with the hum of its blades; goes on evenly when looped."""
    size = 5 * rate
    f = np.fft.rfftfreq(size, 1 / rate)
    shape = (f / 300) / (1 + (f / 300) ** 2) ** 1.1
    rush = np.fft.irfft(shape * np.exp(2j * math.pi * rng.random(f.size)) * (f > 20), size)
    times = np.arange(size) / rate
    hum = sum(np.sin(2 * math.pi * n * 84.0 * times + rng.uniform(0, 6.28)) / n for n in (1, 2, 3, 4))
    return np.asarray(rush / rush.std() + 0.25 * hum, dtype=np.float32)


MAKERS: Mapping[str, Maker] = MappingProxyType(
    {"alarm": alarm, "clap": clap, "door": door, "fan": fan, "knock": knock, "music": music, "step": step}
)
