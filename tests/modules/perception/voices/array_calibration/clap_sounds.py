"""Claps as microphones in the free field hear them, with reverberation after them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.claps import AFTER, BEFORE, HOP_S, Clap
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND
from tests.modules.perception.voices.sounds import CORNERS, as_int16

RATE = 48_000
CROSS = 0.032 * np.array([(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0)])
__all__ = ["CORNERS", "CROSS", "RATE", "around", "clap_of", "heard_at", "recording", "ways"]


def around(count: int, seed: int, level: bool = False) -> NDArray[np.float64]:
    """Places (count, 3) m of claps 1 to 2 m around the array's middle; ``level``: all about at its height."""
    rng = np.random.default_rng(seed)
    azimuths = 2 * np.pi * (np.arange(count) * 0.38 + rng.uniform(-0.05, 0.05, count))
    elevations = np.radians(rng.uniform(-6, 6, count) if level else rng.uniform(-35, 55, count))
    flat = np.cos(elevations)
    toward = np.column_stack([flat * np.cos(azimuths), flat * np.sin(azimuths), np.sin(elevations)])
    return np.asarray(toward * rng.uniform(1, 2, count)[:, None])


def ways(sources: NDArray[np.float64], microphones: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lengths (K, M) m, about their mean, of the ways from ``sources`` (K, 3) to ``microphones`` (M, 3)."""
    apart = np.linalg.norm(sources[:, None] - microphones, axis=2)
    return np.asarray(apart - apart.mean(axis=1, keepdims=True))


def heard_at(
    source: NDArray[np.float64],
    microphones: NDArray[np.float64],
    seed: int,
    *,
    noise: float = 1e-4,
    tail: float = 0.02,
    rate: int = RATE,
) -> NDArray[np.float64]:
    """The sound (N, M) of a clap at ``source`` (3,) m: 50 ms before and 250 ms after it is made."""
    rng = np.random.default_rng(seed)
    before, after = (round(hops * HOP_S * rate) for hops in (BEFORE, AFTER))
    times = np.arange(after) / rate
    dry = np.zeros(before + after)
    dry[before:] = rng.standard_normal(after) * np.exp(-times / 0.002)
    spectrum = np.fft.rfft(dry, 2 * len(dry))
    frequencies = np.fft.rfftfreq(2 * len(dry), 1 / rate)
    spectrum *= 1 / (1 + (frequencies / 6000) ** 4)
    late = np.linalg.norm(source - microphones, axis=1)
    turns = np.exp(-2j * np.pi * frequencies[:, None] * late / SPEED_OF_SOUND) / late
    sound = np.fft.irfft(spectrum[:, None] * turns, axis=0)[: len(dry)]
    reverberation = rng.standard_normal((len(dry), len(microphones)))
    begin = before + round(0.012 * rate)
    fading = np.where(np.arange(len(dry)) >= begin, np.exp(-(np.arange(len(dry)) - begin) / (0.06 * rate)), 0)
    return np.asarray(0.2 * sound + 0.2 * tail * reverberation * fading[:, None] + rng.normal(0, noise, sound.shape))


def clap_of(sound: NDArray[np.float64], rate: int = RATE) -> Clap:
    """As found 5 ms after it left the hands."""
    return Clap(0.0, sound.astype(np.float32), rate, round((BEFORE * HOP_S + 0.004) * rate), False)


def recording(
    sources: NDArray[np.float64],
    microphones: NDArray[np.float64],
    seed: int,
    *,
    gains_db: NDArray[np.float64] | None = None,
    rate: int = RATE,
) -> NDArray[np.int16]:
    """A recording (N, M) of all claps, one every 0.45 s."""
    pause = np.random.default_rng(seed).normal(0, 1e-4, (round(0.15 * rate), len(microphones)))
    pieces = [pause]
    for number, source in enumerate(sources):
        pieces += [heard_at(source, microphones, 100 * seed + number, rate=rate), pause]
    gains = 10 ** (np.zeros(len(microphones)) if gains_db is None else gains_db / 20)
    return as_int16(np.concatenate([*pieces, pause, pause]) * gains)
