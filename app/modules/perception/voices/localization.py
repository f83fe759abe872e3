"""Where sounds come from, by what the microphones' signals have in common: steered response power."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array import MicrophoneArray

SPEED_OF_SOUND = 343.0


@dataclass(frozen=True, slots=True)
class LocalizerSettings:
    """How sounds are looked for.

    ``frame`` samples are transformed at once, every ``frame / 2``; ``frames`` of them make one step. Frequencies in
    Hz. ``memory_s``: time constant of the mean over frames. ``points``: directions compared on the whole sphere, of
    which those above ``lowest_deg`` are looked at. ``range_m``: how far sounds are supposed to be. ``peaks``: most
    directions found in one step.
    """

    frame: int = 1024
    frames: int = 2
    lowest_hz: float = 200.0
    highest_hz: float = 7000.0
    memory_s: float = 0.05
    points: int = 3000
    lowest_deg: float = -20.0
    range_m: float = 1.8
    peaks: int = 4


@dataclass(frozen=True, slots=True, eq=False)
class Peaks:
    """Directions sound came from in one step, strongest first.

    ``directions`` (K, 3) float64, unit vectors from the array's middle in its axes; ``powers`` (K,) float64 in [0, 1]:
    how strongly the microphones agree.
    """

    directions: NDArray[np.float64]
    powers: NDArray[np.float64]


class Localizer:
    """Finds the directions of sounds, step by step; all state is the recent past of the sound itself.

    ``rate`` (Hz) of the samples; ``step``: how many samples :meth:`process` takes at a time.
    """

    def __init__(self, array: MicrophoneArray, rate: int, settings: LocalizerSettings = LocalizerSettings()) -> None:
        self.array = array
        self.rate = rate
        self.settings = settings
        self.hop = settings.frame // 2
        self.step = self.hop * settings.frames
        #: Square root of a Hann window, periodic: its square at hops of half a frame adds up to one.
        self.window = np.sqrt(np.hanning(settings.frame + 1)[:-1]).astype(np.float32)
        frequencies = np.fft.rfftfreq(settings.frame, 1 / rate)
        self.band = np.flatnonzero((frequencies >= settings.lowest_hz) & (frequencies <= settings.highest_hz))
        #: (F, M, frame / 2 + 1) complex64: the windowed spectra of the last step's frames, for a separator.
        self.spectra = np.zeros((settings.frames, len(array), settings.frame // 2 + 1), np.complex64)
        self._past = np.zeros((self.hop, len(array)), np.float32)
        self._cross = np.zeros((len(array.first), len(self.band)), np.complex64)
        self._prepare(np.asarray(frequencies[self.band], np.float64))

    def _prepare(self, frequencies: NDArray[np.float64]) -> None:
        settings, array = self.settings, self.array
        grid = sphere(settings.points)
        self.grid = grid[grid[:, 2] > np.sin(np.radians(settings.lowest_deg))]
        delays = arrivals(array.offsets, self.grid, settings.range_m)
        lags = (delays[:, array.first] - delays[:, array.second]) * self.rate
        longest = int(np.ceil(np.abs(lags).max())) + 1
        self._longest = longest
        times = np.arange(-longest, longest + 1) / self.rate
        turns = np.exp(2j * np.pi * frequencies[:, None] * times)
        # The real part of a complex product, as one product of reals: correlation over lags.
        self._to_lags = np.vstack([turns.real, -turns.imag]).astype(np.float32) / np.float32(len(frequencies))
        rows = np.arange(len(array.first)) * (2 * longest + 1)
        self._cells = np.ascontiguousarray((np.rint(lags).astype(np.int32) + longest + rows).T.astype(np.int32))

    def reset(self) -> None:
        """Forget the past: the next samples do not follow the last."""
        self._past[:] = 0
        self._cross[:] = 0

    def process(self, samples: NDArray[np.float32]) -> Peaks:
        """Hear the next ``step`` samples (step, M), in [-1, 1), columns as the array's positions; where from?"""
        if samples.shape != (self.step, len(self.array)):
            raise ValueError(f"samples are ({self.step}, {len(self.array)}), not {samples.shape}")
        sound = np.concatenate([self._past, samples])
        self._past = sound[-self.hop :]
        size = self.settings.frame
        frames = np.stack([sound[k * self.hop : k * self.hop + size].T for k in range(self.settings.frames)])
        self.spectra = np.fft.rfft(frames * self.window, axis=-1).astype(np.complex64)
        keep = np.exp(-self.hop / self.rate / self.settings.memory_s)
        first, second = self.array.first, self.array.second
        for spectrum in self.spectra[:, :, self.band]:
            phases = spectrum / (np.abs(spectrum) + 1e-9)
            self._cross = keep * self._cross + (1 - keep) * phases[first] * phases[second].conj()
        parts = np.hstack([self._cross.real, self._cross.imag])
        return self._peaks(np.asarray(parts @ self._to_lags, np.float32))

    def _peaks(self, correlation: NDArray[np.float32]) -> Peaks:
        correlation = correlation.copy()
        cells = self._cells
        pairs = len(correlation)
        found, powers = [], []
        around = np.arange(-5, 6)[:, None]
        for _ in range(self.settings.peaks):
            power = correlation.reshape(-1)[cells].sum(axis=0) / pairs
            best = int(power.argmax())
            found.append(self.grid[best])
            powers.append(float(power[best]))
            correlation.reshape(-1)[np.clip(cells[:, best] + around, 0, correlation.size - 1)] = 0
        return Peaks(np.array(found), np.clip(powers, 0, 1))


def sphere(points: int) -> NDArray[np.float64]:
    """``points`` directions (points, 3), evenly over the sphere (Fibonacci's lattice)."""
    index = np.arange(points) + 0.5
    height = 1 - 2 * index / points
    turn = np.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def arrivals(offsets: NDArray[np.float64], directions: NDArray[np.float64], range_m: float) -> NDArray[np.float64]:
    """How much later (s) than in the middle sound of ``directions`` (G, 3), ``range_m`` away, comes to each microphone.

    ``offsets`` (M, 3) m about the middle; the result is (G, M). An infinite range makes the waves plane.
    """
    if np.isinf(range_m):
        return -directions @ offsets.T / SPEED_OF_SOUND
    ways = np.linalg.norm(range_m * directions[:, None] - offsets, axis=2)
    return np.asarray((ways - range_m) / SPEED_OF_SOUND)
