"""Sounds for tests: something like speech, and how microphones hear it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import arrivals

RATE = 48_000
CORNERS = np.array(
    [(x, y, z) for z in (0.105, -0.105) for x, y in ((0.085, 0.11), (0.085, -0.11), (-0.085, -0.11), (-0.085, 0.11))]
)
ARRAY = MicrophoneArray(CORNERS)


def toward(azimuth_deg: float, elevation_deg: float = 15) -> NDArray[np.float64]:
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def babble(seed: int, seconds: float, rate: int = RATE) -> NDArray[np.float32]:
    """Harmonic sound of a wandering pitch, in syllables with pauses: sparse in time and frequency, as speech is."""
    rng = np.random.default_rng(seed)
    count = int(seconds * rate)
    times = np.arange(count) / rate
    knots = np.arange(0, seconds + 0.3, 0.15)
    pitch = np.interp(times, knots, rng.uniform(90, 240, len(knots)))
    loud = np.interp(times, knots, rng.choice([0.0, 0.3, 1.0], len(knots)))
    phase = 2 * np.pi * np.cumsum(pitch) / rate
    sound = sum(np.sin(k * phase) / k**0.8 for k in range(1, 24))
    return np.asarray(0.05 * loud * sound, np.float32)


def heard(sound: NDArray[np.float32], direction: NDArray[np.float64], rate: int = RATE) -> NDArray[np.float32]:
    """The sound at the microphones (N, M), from 1.8 m away, without a room."""
    delays = arrivals(ARRAY.offsets, direction[None], 1.8)[0] + 0.001
    spectrum = np.fft.rfft(sound, 2 * len(sound))
    turns = np.exp(-2j * np.pi * np.fft.rfftfreq(2 * len(sound), 1 / rate)[:, None] * delays)
    return np.fft.irfft(spectrum[:, None] * turns, axis=0)[: len(sound)].astype(np.float32)


def heard_turning(sound: NDArray[np.float32], azimuth_deg: float, turning_degps: float) -> NDArray[np.float32]:
    """As ``heard``, for microphones that turn left in front of a source at rest."""
    times = np.arange(len(sound)) / RATE
    at = np.arange(0, len(sound) + 480, 480)
    directions = np.array([toward(azimuth_deg - turning_degps * t / RATE) for t in at])
    delays = arrivals(ARRAY.offsets, directions, 1.8) + 0.001
    columns = [np.interp(times - np.interp(times, at / RATE, delay), times, sound) for delay in delays.T]
    return np.stack(columns, axis=1).astype(np.float32)


def as_int16(sound: NDArray[np.floating]) -> NDArray[np.int16]:
    """Full scale 1 to full scale 32768."""
    return np.clip(np.rint(sound * 32768), -32768, 32767).astype(np.int16)
