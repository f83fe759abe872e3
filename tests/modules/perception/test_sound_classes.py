"""Classes of sound: by hand, and on the lab's sounds in a room that no threshold was chosen in (docs/noises.md)."""

from __future__ import annotations

import math
import random
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.modules.perception.sound_classes import SoundClassName, SoundFeatures, Thresholds, classify, features
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.acoustics.selfnoise import SelfNoise
from app.robots.simulated.acoustics.sound_library import MEAN_DB_SPL, PEAK_DB_SPL, TALKER_DB_SPL, ClipLibrary
from app.robots.simulated.acoustics.synthesis import MAKERS
from tests.examples_share import fewer

RATE = 48_000
#: Of the robot in the lab (config/robots/irl1_tr.yaml), dB of full scale.
SENSITIVITY_DB, FANS_DB, WHEELS_DB, NOISE_DB = -32.0, -62.0, -52.0, -75.0
MICROPHONE = BaffledMicrophones(np.array([[0.085, 0.11, 0.1]]), RATE, shadow=True)
ROOM = Shoebox((0.0, 0.0, 0.0), (5.0, 6.5, 3.2), (0.5, 0.45))
DOCUMENT = Path(__file__).parents[3] / "docs" / "noises.md"

Sound = NDArray[np.float64]


def gain(db: float) -> float:
    return float(10 ** (db / 20))


def at_level(sound: Sound, db_spl: float, of: float) -> Sound:
    """``sound`` so that its root mean square or peak ``of`` has ``db_spl`` at 1 m."""
    return sound * gain(db_spl - TALKER_DB_SPL + SENSITIVITY_DB) / of


# --- By hand


def stretch(sound: Sound) -> SoundFeatures:
    return features(np.clip(np.rint(sound), -32768, 32767).astype(np.int16), RATE)


def white(seconds: float = 1.0, seed: int = 1) -> Sound:
    return np.random.default_rng(seed).normal(0, 1000, round(seconds * RATE))


@given(st.integers(300, 7500))
def test_a_tone_is_where_it_is(hz: int) -> None:
    found = stretch(3000 * np.sin(2 * np.pi * hz * np.arange(RATE) / RATE))
    assert found.level_db == pytest.approx(20 * math.log10(3000 / 32768 / math.sqrt(2)), abs=0.3)
    assert found.centroid_hz == pytest.approx(hz, abs=20)
    assert found.rolloff_hz == pytest.approx(hz, abs=100)
    assert found.flatness < 0.001
    assert found.steadiness > 0.99
    assert classify(found, Thresholds()) == "tonal"


def test_white_noise_is_flat_and_its_energy_evenly_spread() -> None:
    found = stretch(white())
    assert found.centroid_hz == pytest.approx(4100, rel=0.03)
    assert found.rolloff_hz == pytest.approx(6830, rel=0.03)
    assert found.flatness == pytest.approx(math.exp(-0.5772), abs=0.03), "of single frames, whose lines are exponential"
    assert found.active == 1.0
    assert classify(found, Thresholds()) == "broadband"


def test_a_burst_rises_falls_and_is_short() -> None:
    sound = white(seed=2) / 1000
    begin = round(0.4 * RATE)
    sound[begin:] += 20 * white(0.6) * np.exp(-np.arange(RATE - begin) / (0.01 * RATE))
    found = stretch(sound)
    assert found.onset_db > 30
    assert found.fall_db > 30
    assert found.active < 0.1
    assert classify(found, Thresholds()) == "impulsive"


def test_digital_silence_is_silence() -> None:
    found = stretch(np.zeros(RATE))
    assert found.level_db == pytest.approx(-120.0)
    assert classify(found, Thresholds()) == "silence"


@pytest.mark.parametrize(("count", "rate"), [(1000, RATE), (RATE, 8000)])
def test_too_little_sound_is_refused(count: int, rate: int) -> None:
    with pytest.raises(ValueError, match=f"{count} samples at {rate} Hz; at least 0.2 s at 16000 Hz"):
        features(np.zeros(count, np.int16), rate)


# --- In the lab


def tones(rng: np.random.Generator) -> Sound:
    """4 s of a beeper, a siren or a two-tone horn."""
    t = np.arange(4 * RATE) / RATE
    hz, gate = np.full(t.size, rng.uniform(500, 3200)), np.ones(t.size)
    match int(rng.integers(3)):
        case 0:
            period = rng.uniform(0.4, 1.2)
            gate = (t % period < 0.6 * period).astype(np.float64)
        case 1:
            hz = hz * 2 ** (0.4 * np.sin(2 * np.pi * t / rng.uniform(1.0, 4.0)))
        case _:
            hz = np.where(t % 1.0 < 0.5, hz, hz * rng.uniform(0.7, 0.9))
    phase = 2 * np.pi * np.cumsum(hz) / RATE
    steepness = rng.uniform(1, 2)
    return gate * sum(np.sin(n * phase) / n**steepness for n in (1, 2, 3))


def hiss(rng: np.random.Generator) -> Sound:
    """4 s of air or water: noise that falls by 0 to 6 dB an octave and wanders by 2 dB."""
    hz = np.fft.rfftfreq(4 * RATE, 1 / RATE)
    shape = (np.maximum(hz, 100) / 1000) ** -rng.uniform(0, 1) * (hz < rng.uniform(5000, 16000))
    sound = np.fft.irfft(shape * np.exp(2j * np.pi * rng.random(hz.size)), 4 * RATE)
    t = np.arange(sound.size) / RATE
    return sound * 10 ** (0.1 * np.sin(2 * np.pi * t * rng.uniform(0.1, 0.4) + rng.uniform(0, 6)))


def dry(name: str, rng: np.random.Generator) -> tuple[Sound, float]:
    """The sound called ``name``, amplitude at 1 m, and how long it is to be heard (s)."""
    if name in PEAK_DB_SPL:
        sound = MAKERS[name](RATE, rng).astype(np.float64)
        return at_level(sound, PEAK_DB_SPL[name], float(np.abs(sound).max())), 2.5
    if name in ("reply", "story"):
        clip = ClipLibrary(RATE, SENSITIVITY_DB).get(name)
        return clip.samples.astype(np.float64) * gain(rng.uniform(-3, 6)), min(6.0, clip.seconds + 0.5)
    if name in ("tones", "hiss"):
        sound = {"tones": tones, "hiss": hiss}[name](rng)
        level = rng.uniform(60, 80) if name == "tones" else rng.uniform(52, 75)
        return at_level(sound, level, float(sound.std())), 4.0
    sound = MAKERS[name](RATE, rng).astype(np.float64)
    louder = {"alarm": rng.uniform(-20, 0), "fan": rng.uniform(10, 25), "music": 0.0}[name]
    sound = np.tile(np.roll(sound, -int(rng.integers(sound.size))), -(-4 * RATE // sound.size))
    return at_level(sound, MEAN_DB_SPL[name] + louder, float(sound.std())), 4.0


def heard(name: str, number: int) -> tuple[NDArray[np.int16], NDArray[np.bool_]]:
    """``name`` 1 to 3 m away beside the robot's own noise, and whether it sounds, every 10 ms."""
    rng = np.random.default_rng((zlib.crc32(name.encode()), number, 3))
    if name in ("nothing", "wheels"):
        out, sounds = np.zeros((1, 4 * RATE), np.float32), np.ones(400, np.bool_)
    else:
        sound, seconds = dry(name, rng)
        X_WA = Pose3.from_translation_rpy((2.5, 3.0, 0.9))
        bearing, distance_m = rng.uniform(-np.pi, np.pi), rng.uniform(1, 3)
        place = X_WA.translation + distance_m * np.array([math.cos(bearing), math.sin(bearing), 0.0])
        place = np.clip(place, 0.4, np.array(ROOM.size) - 0.4)
        place[2] = 0.05 if name == "step" else 1.5
        begin_s = rng.uniform(1.0, 1.25) if name in PEAK_DB_SPL else rng.uniform(0.1, 0.4)
        looks = "listener" if name in ("reply", "story") else None
        source = OfflineSource(sound.astype(np.float32), place, begin_s, looks=looks)
        out, (truth,) = render_scene([source], X_WA, ROOM, seconds, MICROPHONE, seed=number)
        sounds = truth.active
    wheels = (np.array([0.0, 0.2, -0.9]), np.array([0.0, -0.2, -0.9]))
    own = SelfNoise(
        MICROPHONE,
        fans=gain(FANS_DB),
        wheels=gain(WHEELS_DB),
        own=gain(NOISE_DB),
        p_AF=np.array([0.0, 0.0, -0.12]),
        p_AL=wheels[0],
        p_AR=wheels[1],
        seed=number,
    )
    speed_mps = 0.4 if name == "wheels" else 0.0
    for at in range(0, out.shape[1] - 511, 512):
        out[:, at : at + 512] += own.frame(at, 512, speed_mps, speed_mps)
    return np.clip(np.rint(out[0] * 32768), -32768, 32767).astype(np.int16), sounds


def stretches(name: str, number: int) -> Iterator[NDArray[np.int16]]:
    """Each second of a scene, every quarter, in which ``name`` begins 0.1 s after its begin and 0.2 s before its end,
    if it is a blow, else sounds for a third of it."""
    sound, sounds = heard(name, number)
    for begin in range(0, len(sound) - RATE + 1, RATE // 4):
        now = sounds[begin // 480 : (begin + RATE) // 480]
        first = int(np.argmax(now)) if now.any() else 0
        if 10 <= first < 80 if name in PEAK_DB_SPL else now.mean() > 1 / 3:
            yield sound[begin : begin + RATE]


#: Sounds, by number of scenes, and the class that each is of; music is of none.
SCENES = {"nothing": 2, "wheels": 2, "reply": 4, "story": 4, "alarm": 3, "tones": 12, "clap": 5, "knock": 5, "door": 5}
SCENES |= {"step": 5, "fan": 3, "hiss": 6, "music": 3}
CLASSES: tuple[SoundClassName, ...] = get_args(SoundClassName)


def confusion(names: Collection[str] = SCENES.keys()) -> dict[str, list[int]]:
    """Number of stretches by sound, of ``names``, and class."""
    table = {}
    for name in names:
        found = Counter(
            classify(features(samples, RATE), Thresholds())
            for number in range(SCENES[name])
            for samples in stretches(name, number)
        )
        table[name] = [found[each] for each in CLASSES]
    return table


@pytest.mark.slow
def test_the_documents_confusion_table_is_measured() -> None:
    lines = DOCUMENT.read_text("utf-8").split("| sound |")[1].split("\n\n")[0].splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    shown = {row[0]: [int(cell) for cell in row[2:]] for row in cells}
    assert list(shown) == list(SCENES)
    # Each row takes a second: with few examples, in each run others.
    tried = min(fewer(len(SCENES)), len(SCENES))
    for name, counts in confusion(random.sample(list(SCENES), tried)).items():
        # Another computer's Fourier transform may put a stretch on the other side of a threshold.
        assert counts == pytest.approx(shown[name], abs=max(2, round(0.03 * sum(counts)))), (name, counts)


if __name__ == "__main__":
    for sound, row in confusion().items():
        print(sound, *row, sep=" | ")
