"""Self-noise of the robot: fans in the torso, wheels and drives below, and the microphones' own noise.

Fans and wheels are cyclic noise, computed once. Fan noise is partly coherent between microphones (through air and
shell) and partly not (turbulence at each microphone); wheel noise comes from the wheels' places, with a level by their
speed. The microphones' own noise is a random part of a long noise for every frame.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import ramp

Samples = NDArray[np.float32]
_LENGTH = 1 << 16
_ALIKE = 0.6
"""Coherent share of the fans' energy."""
WHEELS_AT_MPS = 0.4
"""Rim speed at which the wheels have the configured level."""


class SelfNoise:
    """Gives consecutive frames. Levels are root mean squares over the array, full scale 1.

    ``p_AF`` (3,) m: the fans' place about the array's middle; ``p_AL``, ``p_AR``: the wheels'; ``wheels``: level of
    both at 0.4 m/s.
    """

    def __init__(
        self,
        microphones: BaffledMicrophones,
        fans: float,
        wheels: float,
        own: float,
        p_AF: NDArray[np.float64],
        p_AL: NDArray[np.float64],
        p_AR: NDArray[np.float64],
        seed: int,
    ) -> None:
        seeds = np.random.SeedSequence(seed).spawn(5)
        rate = microphones.rate
        f = np.fft.rfftfreq(_LENGTH, 1 / rate)
        rush = (f / 250) / (1 + (f / 250) ** 2) ** 1.05 * (f > 30)
        common = _heard(microphones, p_AF, rush, seeds[0])
        apart = _shaped(rush, microphones.p_AM.shape[0], np.random.default_rng(seeds[1]))
        hum = _hum(84.0, rate)
        blend = math.sqrt(_ALIKE) * (common + 0.3 * hum) + math.sqrt(1 - _ALIKE) * apart
        self._fans = _level(blend, fans)
        grind = (f / 150) / (1 + (f / 150) ** 2) ** 1.3 * (f > 30) + 0.3 * np.exp(-(((f - 900) / 250) ** 2))
        self._wheels = [
            _level(_heard(microphones, place, grind, seed_), wheels / math.sqrt(2))
            for place, seed_ in ((p_AL, seeds[2]), (p_AR, seeds[3]))
        ]
        self._rng = np.random.default_rng(seeds[4])
        self._own = np.float32(own) * self._rng.standard_normal(8 * _LENGTH, dtype=np.float32)
        self._loudness = np.zeros(2)

    def frame(self, start: int, count: int, left_mps: float, right_mps: float) -> Samples:
        """Samples (M, count) from number ``start`` on, with the wheels' rims at these speeds at the frame's end."""
        out = _round(self._fans, start, count)
        begin = int(self._rng.integers(self._own.size - out.size))
        out += self._own[begin : begin + out.size].reshape(out.shape)
        loudness = np.minimum(np.abs([left_mps, right_mps]) / WHEELS_AT_MPS, 2.0)
        for side in range(2):
            if loudness[side] > 1e-3 or self._loudness[side] > 1e-3:
                out += _round(self._wheels[side], start, count) * ramp(self._loudness[side], loudness[side], count)
        self._loudness = loudness
        return out


def _round(loop: Samples, start: int, count: int) -> Samples:
    at = start % _LENGTH
    if at + count <= _LENGTH:
        return loop[:, at : at + count].copy()
    return np.concatenate([loop[:, at:], loop[:, : at + count - _LENGTH]], axis=1)


def _shaped(shape: NDArray[np.float64], channels: int, rng: np.random.Generator) -> Samples:
    phases = np.exp(2j * math.pi * rng.random((channels, shape.size)))
    noise = np.fft.irfft(shape * phases, _LENGTH)
    return np.asarray(noise / noise.std(), dtype=np.float32)


def _heard(
    microphones: BaffledMicrophones, p_AS: NDArray[np.float64], shape: NDArray[np.float64], seed: np.random.SeedSequence
) -> Samples:
    """Noise of one place at the microphones, cyclic, mean level 1."""
    noise = _shaped(shape, 1, np.random.default_rng(seed))
    responses = microphones.impulses(p_AS[None], np.ones((1, 1)), 1024)[0]
    heard = np.fft.irfft(np.fft.rfft(noise) * np.fft.rfft(responses, _LENGTH), _LENGTH)
    return np.asarray(heard / heard.std(), dtype=np.float32)


def _hum(hz: float, rate: int) -> Samples:
    turns = round(hz * _LENGTH / rate)  # whole turns, so that the loop closes
    phase = 2 * math.pi * turns / _LENGTH * np.arange(_LENGTH)
    return np.asarray(np.sin(phase) + 0.5 * np.sin(2 * phase) + 0.25 * np.sin(3 * phase), dtype=np.float32)


def _level(samples: Samples, level: float) -> Samples:
    return (samples * np.float32(level / samples.std())).astype(np.float32)
