"""How well tracks follow talkers: recall, error, false tracks, latency; and a plain method to be measured beside.

As ODAS's and ManyEars' figures were taken: every 10 ms at which a talker's speech arrives, beginning half a second
into the scene, asks for a track within 20 degrees of him; the error is the angle in space to the nearest such track.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.localization import Localizer
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import search_grid
from app.modules.perception.voices.tracking import Tracker
from benchmarks.voice_rooms import INSTANT_S, SPEED_OF_SOUND, Scene, Talker

WARM_S = 0.5
GATE_DEG = 20.0
Located = list[tuple[float, float, dict[int, NDArray[np.float64]]]]


@dataclass(frozen=True, slots=True)
class Score:
    """Of one scene: ``asked`` instants and ``found`` ones; ``errors_deg`` of those; ``false_s``: how long each track
    was away from everybody; ``latencies_s``: from when a talker is first as loud as the noise, over 10 ms at the first
    microphone (what a recording holds before that is breath and hiss), to the first track near him (inf: none; 0 if
    he was found by what is weaker);
    ``numbers``: how many track numbers each talker had; ``cpu_percent`` of a core."""

    asked: int
    found: int
    errors_deg: NDArray[np.float64]
    false_s: tuple[float, ...]
    latencies_s: tuple[float, ...]
    numbers: tuple[int, ...]
    cpu_percent: float


Angle = Callable[[NDArray[np.float64], NDArray[np.float64]], float]


def in_space(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """The angle between two directions, degrees."""
    return float(np.degrees(2 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))))


def to_line(line: NDArray[np.float64]) -> Angle:
    """The angle that microphones on ``line`` (3,) can know: between the cones of two directions, degrees."""

    def angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        return float(abs(np.degrees(np.arccos(np.clip(a @ line, -1, 1)) - np.arccos(np.clip(b @ line, -1, 1)))))

    return angle


def ours(scene: Scene, array: MicrophoneArray) -> tuple[Located, float]:
    """Tracks over time (when they could be known, what instant they are of, number -> direction), and CPU (%)."""
    samples = np.ascontiguousarray(scene.samples[:, list(array.channels)])
    locate, follow = Localizer(array, scene.rate), Tracker()
    located: Located = []
    began = time.process_time()
    for end in range(locate.step, len(samples) + 1, locate.step):
        peaks = locate.process(samples[end - locate.step : end], follow.expected)
        middle = (end - locate.hop) / scene.rate
        tracks = follow.update(middle, peaks)
        located.append((end / scene.rate, middle, {track.id: track.direction for track in tracks}))
    return located, 100 * (time.process_time() - began) / (len(samples) / scene.rate)


def plain(scene: Scene, array: MicrophoneArray) -> tuple[Located, float]:
    """The same by a plain method: plane waves, one short mean, phases of equal weight, lags erased around each peak.

    Steered response power with phase transform as ManyEars searches it (Valin et al. 2007), followed by nearest
    neighbours and a first-order filter.
    """
    rate, size = scene.rate, 1024
    frequencies = np.fft.rfftfreq(size, 1 / rate)
    band = np.flatnonzero((frequencies >= 200) & (frequencies <= 7000))
    across = array.offsets[array.first] - array.offsets[array.second]
    grid = search_grid(array, 3000, -20.0)
    longest = int(np.ceil(np.linalg.norm(across, axis=1).max() / SPEED_OF_SOUND * rate)) + 6
    turns = np.exp(2j * np.pi * frequencies[band, None] * np.arange(-longest, longest + 1) / rate)
    to_lags = np.vstack([turns.real, -turns.imag]).astype(np.float32) / np.float32(len(band))
    rows = np.arange(len(across)) * (2 * longest + 1) + longest
    cells = np.ascontiguousarray((np.rint(-grid @ across.T / SPEED_OF_SOUND * rate).astype(int) + rows).T)
    window = np.sqrt(np.hanning(size + 1)[:-1]).astype(np.float32)
    samples = scene.samples[:, list(array.channels)].T
    cross = np.zeros((len(across), len(band)), np.complex64)
    followed = _NearestNeighbours()
    located: Located = []
    began = time.process_time()
    for number, begin in enumerate(range(0, samples.shape[1] - size + 1, size // 2)):
        spectra = np.fft.rfft(samples[:, begin : begin + size] * window)[:, band].astype(np.complex64)
        phases = spectra / (np.abs(spectra) + 1e-9)
        cross = 0.8 * cross + 0.2 * phases[array.first] * phases[array.second].conj()
        if number % 2:
            continue
        correlation = (np.hstack([cross.real, cross.imag]) @ to_lags).reshape(-1)
        peaks = []
        for _ in range(4):
            response = correlation[cells].sum(axis=0) / len(across)
            best = int(response.argmax())
            peaks.append((grid[best], float(response[best])))
            correlation[cells[:, best] + np.arange(-5, 6)[:, None]] = 0
        tracks = followed.update((begin + size / 2) / rate, peaks)
        located.append(((begin + size) / rate, (begin + size / 2) / rate, tracks))
    return located, 100 * (time.process_time() - began) / (samples.shape[1] / rate)


class _NearestNeighbours:
    def __init__(self) -> None:
        self._tracks: dict[int, tuple[NDArray[np.float64], float]] = {}
        self._seen: list[tuple[NDArray[np.float64], int, float]] = []
        self._next = 1

    def update(self, now: float, peaks: list[tuple[NDArray[np.float64], float]]) -> dict[int, NDArray[np.float64]]:
        free = list(peaks)
        for number, (direction, _) in list(self._tracks.items()):
            near = [peak for peak in free if peak[1] > 0.035 and in_space(peak[0], direction) < 12]
            if near:
                best = max(near, key=lambda peak: peak[1])
                free = [peak for peak in free if peak is not best]
                gain = min(0.35, 0.06 + 0.5 * best[1])
                moved = (1 - gain) * direction + gain * best[0]
                self._tracks[number] = (moved / np.linalg.norm(moved), now)
        self._tracks = {n: (d, last) for n, (d, last) in self._tracks.items() if now - last < 1.5}
        self._seen = [entry for entry in self._seen if now - entry[2] < 0.25]
        for direction, power in free:
            taken = any(in_space(direction, track) < 20 for track, _ in self._tracks.values())
            if power < 0.06 or taken or len(self._tracks) >= 4:
                continue
            near_by = next((k for k, entry in enumerate(self._seen) if in_space(direction, entry[0]) < 10), None)
            count = 1 if near_by is None else self._seen.pop(near_by)[1] + 1
            if count >= 5:
                self._tracks[self._next] = (direction, now)
                self._next += 1
            else:
                self._seen.append((direction, count, now))
        return {number: direction for number, (direction, _) in self._tracks.items()}


def score(scene: Scene, located: Located, cpu_percent: float, angle: Angle = in_space) -> Score:
    """Compare what was ``located`` with who spoke."""
    known = np.array([when for when, _, _ in located])
    asked, errors, latencies, numbers = 0, [], [], []
    for talker, onset in zip(scene.talkers, _onsets(scene), strict=True):
        found, first, near = _follow(talker, located, known, angle, onset)
        asked += found.size
        errors += found[~np.isnan(found)].tolist()
        latencies.append(first)
        numbers.append(len(near))
    away: dict[int, float] = {}
    step = known[1] - known[0]
    for _, instant, tracks in located:
        for number, direction in tracks.items():
            if min(angle(direction, talker.direction(instant)) for talker in scene.talkers) > GATE_DEG:
                away[number] = away.get(number, 0.0) + step
    return Score(
        asked, len(errors), np.array(errors), tuple(away.values()), tuple(latencies), tuple(numbers), cpu_percent
    )


def _onsets(scene: Scene) -> list[float]:
    """Time (s) at which each talker is first as loud as the noise; without a recording of the talker alone, of the
    first speech."""
    if not len(scene.alone):
        return [float(np.flatnonzero(talker.active)[0]) * INSTANT_S for talker in scene.talkers]
    noise = float(np.mean((scene.samples[:, 0] - scene.alone.sum(axis=0)) ** 2))
    length = int(INSTANT_S * scene.rate)
    frames = scene.alone[:, : scene.alone.shape[1] // length * length].reshape(len(scene.alone), -1, length)
    return [float(np.argmax((sound**2).mean(axis=1) > noise)) * INSTANT_S for sound in frames]


def _follow(
    talker: Talker, located: Located, known: NDArray[np.float64], angle: Angle, onset: float
) -> tuple[NDArray[np.float64], float, set[int]]:
    """The error (deg, NaN: missed) at each asked instant; how long until he was found; his track's numbers."""
    errors, first, numbers = [], np.inf, set()
    speaking = np.flatnonzero(talker.active) * INSTANT_S
    for instant in speaking:
        latest = int(np.searchsorted(known, instant, side="right")) - 1
        if instant > known[-1]:
            break
        tracks = located[latest][2] if latest >= 0 else {}
        truth = talker.direction(instant)
        nearest, number = min(((angle(direction, truth), n) for n, direction in tracks.items()), default=(np.inf, 0))
        if nearest < GATE_DEG:
            numbers.add(number)
            first = min(first, max(0.0, float(instant) - onset))
        if instant >= WARM_S:
            errors.append(nearest if nearest < GATE_DEG else np.nan)
    return np.array(errors), first, numbers
