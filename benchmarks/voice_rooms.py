"""Rooms with people talking in them, for measuring the localization of voices: sound by image sources, and the truth.

Free-field omnidirectional microphones 1 m above the floor of a shoebox room, real recorded speech (16 kHz and more, set
to one loudness), mouths 1.4 to 1.8 m high, 1.2 to 2.3 m away and at least 40 degrees apart, white noise in every
microphone. Walking people go 120 degrees round the robot in 10 s, pairs toward one another and past. Everything drawn
comes from a scene's own seed. Talkers and rooms of :data:`TUNING` are never those of :data:`HELD_OUT`.
"""

from __future__ import annotations

import hashlib
import json
import math
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyroomacoustics as pra
import soundfile
from numpy.typing import NDArray
from scipy.signal import fftconvolve, resample_poly

RATE = 48_000
SPEED_OF_SOUND = 343.0
#: Instants at which people are asked whether they speak (s).
INSTANT_S = 0.01
BLOCK_S = 0.1
HEIGHT_M = 1.0
APART_DEG = 40.0
#: The corners of a box of 0.2 x 0.3 x 0.4 m.
BOX = np.array(
    [[x * 0.10, y * 0.15, z * 0.20] for z in (1, -1) for x, y in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cast:
    """Who may talk where: ``speakers`` (name -> files), ``rooms`` (m, drawn within these corners)."""

    name: str
    speakers: dict[str, tuple[str, ...]]
    room_min: tuple[float, float, float]
    room_max: tuple[float, float, float]


TUNING = Cast(
    "tuning",
    {
        "aew": tuple(f"cmu_arctic_us_aew_a000{i}.wav" for i in (1, 2, 3)),
        "librivox": tuple(f"librivox_sense_0{i}.wav" for i in (870, 890, 920)),
        "asterisk en": ("asterisk_en_demo-congrats.wav", "asterisk_en_priv-callee-options.wav"),
        "arctic": ("cmu_arctic_a0010.wav",),
    },
    (6.0, 5.0, 3.0),
    (6.0, 5.0, 3.0),
)
#: The talkers of tuning in rooms as various as those held out.
TUNING_WIDE = Cast("tuning wide", TUNING.speakers, (4.8, 4.2, 2.6), (8.0, 7.0, 3.4))
HELD_OUT = Cast(
    "held out",
    {
        "axb": tuple(f"cmu_arctic_us_axb_a000{i}.wav" for i in (4, 6)),
        "jfk": ("jfk.flac",),
        "asterisk fr": ("asterisk_fr_demo-congrats.wav", "asterisk_fr_priv-callee-options.wav"),
        "numbers": ("pocketsphinx_numbers.wav",),
        "goforward": ("pocketsphinx_goforward.wav",),
    },
    (4.8, 4.2, 2.6),
    (8.0, 7.0, 3.4),
)


@dataclass(frozen=True, slots=True)
class Talker:
    """One person: ``times`` (T,) s, ``directions`` (T, 3) unit vectors from the array's middle, distance (m);
    ``active`` (N,) bool: whether speech arrives, every ``INSTANT_S``."""

    file: str
    times: NDArray[np.float64]
    directions: NDArray[np.float64]
    distance_m: float
    active: NDArray[np.bool_]

    def direction(self, time_s: float) -> NDArray[np.float64]:
        """Where it is heard from at ``time_s``: a unit vector (3,)."""
        at = np.array([np.interp(time_s, self.times, self.directions[:, k]) for k in range(3)])
        return at / float(np.linalg.norm(at))


@dataclass(frozen=True, slots=True)
class Scene:
    """What the microphones heard, ``samples`` (N, M) float32 in [-1, 1), and who spoke.

    ``alone`` (K, N) float32: each talker by itself as microphone 0 heard it, without noise, in the scale of
    ``samples``.
    """

    name: str
    rate: int
    positions: NDArray[np.float64]
    samples: NDArray[np.float32]
    alone: NDArray[np.float32]
    talkers: tuple[Talker, ...]


@dataclass(frozen=True, slots=True)
class Recipe:
    """What a scene is made of; equal recipes make equal scenes."""

    cast: str
    talkers: int
    rt60_s: float
    snr_db: float
    walking: bool
    seed: int
    duration_s: float = 6.0


def reference_speech(folder: Path, file: str) -> NDArray[np.float64]:
    """A recording as (N,) float64 at ``RATE``, at an RMS of 0.05 where it sounds."""
    samples, rate = soundfile.read(folder / file)
    if samples.ndim > 1:
        samples = samples.mean(1)
    divisor = math.gcd(rate, RATE)
    samples = resample_poly(samples, RATE // divisor, rate // divisor)
    sounding = np.abs(samples) > 0.02 * np.abs(samples).max()
    return np.asarray(0.05 * samples / np.sqrt((samples[sounding] ** 2).mean()))


def speaking(dry: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where speech is within 35 dB of its loudest, every ``INSTANT_S``."""
    length = int(INSTANT_S * RATE)
    frames = dry[: len(dry) // length * length].reshape(-1, length)
    level = 10 * np.log10((frames**2).mean(1) + 1e-12)
    return np.asarray(level > level.max() - 35)


@dataclass(frozen=True, slots=True)
class Plan:
    """What a recipe's seed draws: the room's ``size`` (3,) m, the array's ``middle`` (3,), each talker's file and path
    (T, 3), one place every ``BLOCK_S`` or one for all; ``rng`` for what comes after."""

    size: NDArray[np.float64]
    middle: NDArray[np.float64]
    files: list[str]
    paths: list[NDArray[np.float64]]
    rng: np.random.Generator


def draw(recipe: Recipe) -> Plan:
    """Draw a scene."""
    cast = next(cast for cast in (TUNING, TUNING_WIDE, HELD_OUT) if cast.name == recipe.cast)
    rng = np.random.default_rng(recipe.seed)
    size = rng.uniform(cast.room_min, cast.room_max)
    # Never in the very middle, where the reflections of opposite walls come together.
    middle = np.array([*(size[:2] * rng.uniform(0.42, 0.47, 2)), HEIGHT_M])
    speakers = rng.choice(sorted(cast.speakers), recipe.talkers, replace=False)
    files = [str(rng.choice(cast.speakers[speaker])) for speaker in speakers]
    if recipe.walking:
        paths = _walks(recipe, rng, size, middle)
    else:
        paths = _places(recipe.talkers, rng, size, middle)
    return Plan(size, middle, files, paths, rng)


def talk(speech: Path, file: str, length: int) -> NDArray[np.float64]:
    """``length`` samples of a recording, said again and again with 0.3 s between."""
    return np.resize(np.concatenate([reference_speech(speech, file), np.zeros(int(0.3 * RATE))]), length)


def make(recipe: Recipe, positions: NDArray[np.float64], speech: Path) -> Scene:
    """Play ``recipe`` to microphones at ``positions`` (M, 3), m about their middle."""
    plan = draw(recipe)
    rng, size, middle, files, paths = plan.rng, plan.size, plan.middle, plan.files, plan.paths
    length = int(recipe.duration_s * RATE)
    dry = [talk(speech, file, length) for file in files]
    heard = np.zeros((recipe.talkers, len(positions), length))
    talkers = []
    for number, (sound, path) in enumerate(zip(dry, paths, strict=True)):
        heard[number] = _propagate(sound, path, size, middle + positions, recipe.rt60_s)
        offsets = path - middle
        distance = np.linalg.norm(offsets, axis=1)
        late = np.zeros(int(distance.mean() / SPEED_OF_SOUND / INSTANT_S), bool)
        active = np.concatenate([late, speaking(sound)])
        times = np.arange(len(path), dtype=np.float64) * BLOCK_S
        directions = (offsets / distance[:, None]).astype(np.float64)
        talkers.append(Talker(files[number], times, directions, float(distance.mean()), active))
    mixed = heard.sum(0)
    mixed += rng.normal(0, np.sqrt((mixed**2).mean()) * 10 ** (-recipe.snr_db / 20), mixed.shape)
    scale = 0.3 / np.abs(mixed).max()
    samples = np.round(mixed.T * scale * 32768) / 32768  # as 16 bits keep it
    alone = heard[:, 0] * scale
    name = f"{recipe.cast} {recipe.talkers}{' walking' if recipe.walking else ''}"
    name += f", RT60 {recipe.rt60_s:g} s, {recipe.snr_db:g} dB, seed {recipe.seed}"
    return Scene(name, RATE, positions, samples.astype(np.float32), alone.astype(np.float32), tuple(talkers))


def cached(recipe: Recipe, positions: NDArray[np.float64], speech: Path) -> Scene:
    """As :func:`make`, kept in the temporary folder: image sources take their time."""
    folder = Path(tempfile.gettempdir()) / "hbba-voice-rooms"
    folder.mkdir(exist_ok=True)
    key = json.dumps([2, asdict(recipe), np.round(positions, 6).tolist()])
    path = folder / f"{hashlib.sha256(key.encode()).hexdigest()[:24]}.npz"
    if not path.is_file():
        scene = make(recipe, positions, speech)
        content: dict[str, Any] = {"samples": (scene.samples * 32768).astype(np.int16)}
        content["alone"] = scene.alone.astype(np.float16)
        for number, talker in enumerate(scene.talkers):
            content[f"times{number}"] = talker.times
            content[f"directions{number}"] = talker.directions
            content[f"active{number}"] = talker.active
        about = [scene.name, [[talker.file, talker.distance_m] for talker in scene.talkers]]
        partial = path.with_suffix(".part.npz")
        np.savez(partial, about=np.array(json.dumps(about)), **content)
        partial.replace(path)
    with np.load(path) as stored:
        name, people = json.loads(str(stored["about"]))
        talkers = tuple(
            Talker(file, stored[f"times{k}"], stored[f"directions{k}"], distance, stored[f"active{k}"])
            for k, (file, distance) in enumerate(people)
        )
        samples = stored["samples"].astype(np.float32) / 32768
        return Scene(name, RATE, positions, samples, stored["alone"].astype(np.float32), talkers)


def recipes(
    cast: Cast, talkers: int, rt60_s: float, snr_db: float, count: int, walking: bool = False, first: int | None = None
) -> list[Recipe]:
    """``count`` scenes of one kind. Seeds from ``first`` on; else from 1000 (tuning) or 2000 (held out)."""
    if first is None:
        first = 1000 if cast is TUNING else 2000
    duration = 10.0 if walking else 6.0
    return [Recipe(cast.name, talkers, rt60_s, snr_db, walking, first + k, duration) for k in range(count)]


def _places(
    count: int, rng: np.random.Generator, size: NDArray[np.float64], middle: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    while True:
        azimuths = rng.uniform(-180, 180, count)
        apart = [abs((a - b + 180) % 360 - 180) for k, a in enumerate(azimuths) for b in azimuths[:k]]
        if any(angle < APART_DEG for angle in apart):
            continue
        places = [_place(a, rng.uniform(1.2, 2.3), rng.uniform(1.4, 1.8), size, middle) for a in azimuths]
        found = [place for place in places if place is not None]
        if len(found) == count:
            return [place[None] for place in found]


def _walks(
    recipe: Recipe, rng: np.random.Generator, size: NDArray[np.float64], middle: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    instants = np.arange(math.ceil(recipe.duration_s / BLOCK_S) + 2) * BLOCK_S
    while True:
        toward = rng.uniform(-180, 180)
        paths = []
        for number in range(recipe.talkers):
            begin = toward + (-60 if number % 2 == 0 else 60)
            turn = 120 if number % 2 == 0 else -120
            distance, height = rng.uniform(1.4, 1.9), rng.uniform(1.5, 1.7)
            azimuths = begin + turn * np.minimum(1.0, instants / recipe.duration_s)
            places = [_place(a, distance, height, size, middle) for a in azimuths]
            paths.append([place for place in places if place is not None])
        if all(len(path) == len(instants) for path in paths):
            return [np.array(path) for path in paths]


def _place(
    azimuth_deg: float, distance: float, height: float, size: NDArray[np.float64], middle: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    rise = height - middle[2]
    away = math.sqrt(max(distance**2 - rise**2, 0.01))
    angle = math.radians(azimuth_deg)
    place = middle + np.array([away * math.cos(angle), away * math.sin(angle), rise])
    return place if ((place > 0.3) & (place < size - 0.3)).all() else None


def _propagate(
    dry: NDArray[np.float64],
    path: NDArray[np.float64],
    size: NDArray[np.float64],
    microphones: NDArray[np.float64],
    rt60_s: float,
) -> NDArray[np.float64]:
    """``dry`` (N,) from ``path`` (T, 3), one place every ``BLOCK_S`` (or one for all), at each microphone: (M, N)."""
    if len(path) == 1:
        return np.stack([fftconvolve(dry, h)[: len(dry)] for h in _responses(path[0], size, microphones, rt60_s)])
    block = int(BLOCK_S * RATE)
    fade = np.hanning(2 * block + 1)[:-1]
    heard = np.zeros((len(microphones), len(dry) + 2 * RATE))
    padded = np.concatenate([np.zeros(block), dry, np.zeros(2 * block)])
    for number in range(math.ceil(len(dry) / block) + 1):
        begin = number * block  # in padded: the block centred on instant number * BLOCK_S
        part = padded[begin : begin + 2 * block] * fade[: len(padded) - begin]
        for microphone, response in enumerate(_responses(path[number], size, microphones, rt60_s)):
            sound = fftconvolve(part, response)
            skip = max(0, block - begin)
            sound = sound[skip:]
            at = max(0, begin - block)
            heard[microphone, at : at + len(sound)] += sound[: heard.shape[1] - at]
    return heard[:, : len(dry)]


def _responses(
    place: NDArray[np.float64], size: NDArray[np.float64], microphones: NDArray[np.float64], rt60_s: float
) -> Sequence[NDArray[np.float64]]:
    absorption, order = pra.inverse_sabine(rt60_s, size)
    room = pra.ShoeBox(
        size, fs=RATE, materials=pra.Material(absorption), max_order=min(order, 17), air_absorption=True
    )  # fmt: skip
    room.add_source(place)
    room.add_microphone_array(microphones.T)
    room.compute_rir()
    # The fractional delay filters come half their length late.
    late = pra.constants.get("frac_delay_length") // 2
    return [np.asarray(room.rir[m][0])[late:] for m in range(len(microphones))]
