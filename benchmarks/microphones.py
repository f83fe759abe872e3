"""How well claps calibrate an array: positions, gains, order, and what directions of voices gain by it.

Rooms of the simulated body's acoustics, 4.8 to 8 by 4.2 to 7 by 2.6 to 3.4 m. The array is 1.1 m above the floor, its
middle off the room's; its microphones are off their configured places (6 mm standard deviation along each axis, of the
small one 2 mm within its plane), and their levels 2 dB. No two are alike: each passes what is below a frequency of its
own from 12 to 20 kHz, and so delays by 8 to 13 µs. Sixteen claps come from 1 to 2 m, all around, some high and some
low; around the flat array, at its height within 10 cm. SNR is the median clap's peak over the RMS of the noise, which
is independent in all microphones. The truth is laid over the configuration first: how the whole is turned, no sound
shows. Errors of positions are RMS; directions are those of a talker in the same room, by the voices' own localization.
"""

# ruff: noqa: E402

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass

for _library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_library, "1")

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve, lfilter

from app.base.geometry import Pose3
from app.modules.perception.voices.array_calibration.calibration import calibrate
from app.modules.perception.voices.array_calibration.claps import ClapDetector
from app.modules.perception.voices.array_calibration.results import Calibration, Verdict
from app.modules.perception.voices.array_calibration.structure import aligned
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.room import Shoebox, response
from app.robots.simulated.acoustics.sound_library import ClipLibrary
from app.robots.simulated.acoustics.synthesis import clap
from benchmarks.report import Row, benchmark_main, row
from benchmarks.voice_arrays import CROSS
from benchmarks.voice_rooms import BOX, RATE, Scene
from benchmarks.voice_scoring import in_space, ours
from benchmarks.voices import arrays

BENCHMARK = "microphones"
#: RT60 (s) and SNR (dB).
ROOMS = ((0.3, 40.0), (0.6, 30.0))
SEEDS, CLAPS = 6, 16
HEIGHT_M = 1.1
GAIN_DB = 2.0
#: A clap every so often (s), the first after this.
EVERY_S, FIRST_S = 1.2, 0.8
TALK_S = 3.0
#: Reflections are single ones for so long after the direct sound (s), and diffuse later.
EARLY_S = 0.02
Positions = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Kind:
    """An array: ``configured`` (M, 3) m about its middle, off by ``off_m`` along each axis of its own; ``body_m`` of a
    torso (a rigid sphere through the microphones)."""

    configured: Positions
    off_m: float
    body_m: float = 0.0

    @property
    def flat(self) -> bool:
        """Whether it lies in a level plane."""
        return bool(np.ptp(self.configured[:, 2]) == 0)

    def true(self, rng: np.random.Generator, off: bool) -> Positions:
        """Where its microphones really are."""
        placed = self.configured + (self.off_m if off else 0) * rng.standard_normal(self.configured.shape) * (
            np.array([1, 1, 0]) if self.flat else 1
        )
        placed -= placed.mean(axis=0)
        if self.body_m:
            # They stay on its surface.
            placed *= self.body_m / np.linalg.norm(placed, axis=1, keepdims=True)
        return aligned(placed, self.configured)


def kinds() -> dict[str, Kind]:
    """The arrays, by name."""
    irl1 = arrays()["IRL-1"].offsets
    return {
        "0.2 x 0.3 x 0.4 m, 8": Kind(BOX, 0.006),
        "IRL-1, 8": Kind(irl1, 0.006),
        "IRL-1 on its torso, 8": Kind(irl1, 0.006, float(np.linalg.norm(irl1[0]))),
        "cross of 64 mm, 4": Kind(CROSS, 0.002),
    }


@dataclass(frozen=True, slots=True)
class Trial:
    """What one seed gave: errors of positions (mm) ``before`` and ``after``, held-out errors of arrival times (µs), of
    gains (dB), of a talker's direction (deg) by the configured, the calibrated and the true positions."""

    result: Calibration
    before_mm: float
    after_mm: float
    gain_db: float
    direction_deg: tuple[float, float, float]


class Room:
    """The room of one seed and an array in it."""

    def __init__(self, kind: Kind, true: Positions, rt60_s: float, seed: int) -> None:
        self._rng = np.random.default_rng(1000 + seed)
        self.size = self._rng.uniform((4.8, 4.2, 2.6), (8.0, 7.0, 3.4))
        self.middle = np.array([*(self.size[:2] * self._rng.uniform(0.42, 0.47, 2)), HEIGHT_M])
        self._kind = kind
        self._room = Shoebox((0.0, 0.0, 0.0), tuple(self.size), (rt60_s, rt60_s))
        self._microphones = BaffledMicrophones(true, RATE, shadow=kind.body_m > 0)
        self._passed_hz = self._rng.uniform(12e3, 20e3, len(true))

    def place(self, number: int) -> Positions:
        """A place (3,) m, inside, for clap ``number``; azimuths go round by the golden angle."""
        while True:
            azimuth = 2.4 * number + self._rng.uniform(-0.4, 0.4)
            away = self._rng.uniform(1.0, 2.0)
            elevation = self._rng.uniform(-0.1, 0.1) / away if self._kind.flat else self._rng.uniform(-0.6, 0.8)
            flat = np.cos(elevation)
            toward = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
            found = self.middle + away * toward
            if ((found > 0.15) & (found < self.size - 0.15)).all():
                return np.asarray(found)

    def hear(self, sound: NDArray[np.float32], place: Positions, looks: bool = False) -> NDArray[np.float64]:
        """``sound`` from ``place`` at the microphones (M, N)."""
        toward = (self.middle - place) / np.linalg.norm(self.middle - place) if looks else None
        impulses = response(
            self._room, place, Pose3.from_translation_rpy(tuple(self.middle)), self._microphones,
            looks=toward, early_s=EARLY_S, seed=int(self._rng.integers(1 << 30)),
        )  # fmt: skip
        heard = fftconvolve(impulses, sound[None], axes=1)
        kept = np.exp(-2 * np.pi * self._passed_hz / RATE)
        return np.array([lfilter([1 - one], [1, -one], row) for one, row in zip(kept, heard, strict=True)], np.float64)

    def claps(self, gains_db: NDArray[np.float64], snr_db: float) -> NDArray[np.int16]:
        """A recording (N, M) of all claps, each hand's own."""
        count = len(self._kind.configured)
        sound = np.zeros((count, round((FIRST_S + CLAPS * EVERY_S) * RATE)))
        peaks = []
        for number in range(CLAPS):
            heard = self.hear(clap(RATE, self._rng) * self._rng.uniform(0.5, 1), self.place(number))
            begin = round((FIRST_S + number * EVERY_S) * RATE)
            length = min(heard.shape[1], sound.shape[1] - begin)
            sound[:, begin : begin + length] += heard[:, :length]
            peaks.append(float(np.abs(heard).max()))
        noise = float(np.median(peaks)) * 10 ** (-snr_db / 20)
        sound += self._rng.normal(0, noise, sound.shape)
        sound *= 10 ** (gains_db / 20)[:, None]
        return np.asarray(np.rint(sound.T * (0.5 * 32768 / np.abs(sound).max())), np.int16)

    def talk(self, gains_db: NDArray[np.float64]) -> tuple[Scene, Positions]:
        """A talker 1.2 to 2 m away, 20 dB over the noise, and the direction (3,) from the middle."""
        place = self.place(int(self._rng.integers(100)))
        speech = ClipLibrary(RATE, -32.0).get("story").samples[: round(TALK_S * RATE)]
        heard = self.hear(speech, place, looks=True)[:, : round(TALK_S * RATE)]
        heard += self._rng.normal(0, np.sqrt((heard**2).mean()) / 10, heard.shape)
        heard *= 10 ** (gains_db / 20)[:, None] * (0.3 / np.abs(heard).max())
        scene = Scene("talk", RATE, self._kind.configured, heard.T.astype(np.float32), heard[:0].astype(np.float32), ())
        toward = place - self.middle
        return scene, np.asarray(toward / np.linalg.norm(toward))


def rms_mm(found: Positions, true: Positions) -> float:
    """RMS distance, both laid over one another."""
    return 1e3 * float(np.sqrt(((aligned(found, true) - true) ** 2).sum(axis=1).mean()))


def direction_deg(scene: Scene, array: MicrophoneArray, toward: Positions) -> float:
    """Median angle between the talker and the nearest track, after the first second; of a flat array, of azimuths."""
    located, _ = ours(scene, array)
    mask = np.array([1, 1, 0]) if array.dimensions == 2 else np.ones(3)

    def angle(track: Positions) -> float:
        one, other = track * mask, toward * mask
        return in_space(one / np.linalg.norm(one), other / np.linalg.norm(other))

    errors = [min(map(angle, tracks.values())) for _, middle, tracks in located if middle > 1 and tracks]
    return float(np.median(errors)) if errors else np.nan


def trial(kind: Kind, rt60_s: float, snr_db: float, *, seed: int, off: bool = True) -> list[Trial]:
    """A calibration, and one of the same claps with two channels exchanged; unless the microphones are ``off`` their
    configured places, the first alone, and without a talker."""
    rng = np.random.default_rng(seed)
    true = kind.true(rng, off)
    gains = rng.normal(0, GAIN_DB, len(true))
    room = Room(kind, true, rt60_s, seed)
    sound = room.claps(gains, snr_db)
    result = calibrated(kind, sound)
    if not off:
        return [judged(kind, result, true, gains)]
    scene, toward = room.talk(gains)
    placed = (kind.configured, result.positions, true)
    three = [direction_deg(scene, MicrophoneArray(one, body_m=kind.body_m), toward) for one in placed]
    order = np.arange(len(true))
    first, second = rng.choice(len(true), 2, replace=False)
    order[[first, second]] = order[[second, first]]
    return [
        judged(kind, result, true, gains, directions=(three[0], three[1], three[2])),
        judged(kind, calibrated(kind, sound[:, order]), true[order], gains[order]),
    ]


def calibrated(kind: Kind, sound: NDArray[np.int16]) -> Calibration:
    """The calibration by a recording (N, M)."""
    detector = ClapDetector(RATE, sound.shape[1])
    claps = [one for begin in range(0, len(sound), 4096) for one in detector.process(sound[begin : begin + 4096])]
    return calibrate(claps, MicrophoneArray(kind.configured, body_m=kind.body_m))


def judged(
    kind: Kind,
    result: Calibration,
    true: Positions,
    gains_db: NDArray[np.float64],
    directions: tuple[float, float, float] = (np.nan, np.nan, np.nan),
) -> Trial:
    """``result`` beside the truth."""
    found = np.array([one.gain_db for one in result.microphones])
    return Trial(
        result,
        rms_mm(kind.configured, true),
        rms_mm(result.positions, true),
        float(np.sqrt(np.mean((found - (gains_db - np.median(gains_db))) ** 2))),
        directions,
    )


def rows_of(case: str, trials: Sequence[Trial]) -> list[Row]:
    """The figures of the seeds of one case."""
    held = [(1e6 * one.result.held_out_before_s, 1e6 * one.result.held_out_after_s) for one in trials]
    configured, calibrated, true = zip(*(one.direction_deg for one in trials), strict=True)
    columns: list[tuple[str, str, Sequence[float]]] = [
        ("positions as configured", "mm", [one.before_mm for one in trials]),
        ("positions calibrated", "mm", [one.after_mm for one in trials]),
        ("positions calibrated, worst", "mm", [max(one.after_mm for one in trials)]),
        ("held-out arrivals as configured", "µs", [before for before, _ in held]),
        ("held-out arrivals calibrated", "µs", [after for _, after in held]),
        ("gains", "dB", [one.gain_db for one in trials]),
        ("claps used", "", [sum(clap.used for clap in one.result.claps) for one in trials]),
        ("verdict adopt", "", [sum(one.result.verdict is Verdict.ADOPT for one in trials)]),
        ("verdict keep", "", [sum(one.result.verdict is Verdict.KEEP for one in trials)]),
        ("talker as configured", "deg", configured),
        ("talker calibrated", "deg", calibrated),
        ("talker by the true positions", "deg", true),
    ]
    return [
        row(BENCHMARK, case, metric, unit, [value for value in values if np.isfinite(value)])
        for metric, unit, values in columns
        if np.isfinite(values).any()
    ]


def measure(quick: bool) -> list[Row]:
    """All of it."""
    seeds = range(2 if quick else SEEDS)
    rows: list[Row] = []
    for name, kind in kinds().items():
        for rt60_s, snr_db in ROOMS[:1] if quick else ROOMS:
            case = f"{name}, RT60 {rt60_s:g} s, {snr_db:g} dB"
            asis, swapped = zip(*(trial(kind, rt60_s, snr_db, seed=seed) for seed in seeds), strict=True)
            rows += rows_of(case, asis) + rows_of(f"{case}, two swapped", swapped)
            said = sum(one.result.order is not None for one in swapped)
            rows.append(row(BENCHMARK, f"{case}, two swapped", "another order said", "", [said]))
        rt60_s, snr_db = ROOMS[0]
        rows += rows_of(
            f"{name}, as configured", [trial(kind, rt60_s, snr_db, seed=seed, off=False)[0] for seed in seeds]
        )
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
