from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.resampling import Resampler
from app.modules.perception.voices.voice_activity import CHUNK, MODEL, SPEECH_RATE, VoiceActivityDetector


def reference_speech() -> Path:
    here = Path(__file__).parents[4]
    folder = Path(os.environ.get("HBBA_REFERENCE_DATA") or here.parent / "shared" / "data") / "speech"
    if not folder.is_dir():
        pytest.skip(f"no reference speech in {folder}; HBBA_REFERENCE_DATA names the folder of reference data")
    return folder


def read(path: Path) -> NDArray[np.float32]:
    soundfile = pytest.importorskip("soundfile")
    sound, rate = soundfile.read(path, dtype="float32", always_2d=True)
    return Resampler(rate, SPEECH_RATE).process(np.ascontiguousarray(sound.mean(axis=1)))


def judged(sound: NDArray[np.float32]) -> NDArray[np.float64]:
    """Every single judgement of a sound."""
    detector = VoiceActivityDetector(window=1)
    found = []
    for begin in range(0, len(sound) - CHUNK + 1, CHUNK):
        detector.update({1: sound[begin : begin + CHUNK]})
        found.append(detector.speech(1))
    return np.array(found)


def test_noise_tones_and_clicks_are_no_voice() -> None:
    rng = np.random.default_rng(1)
    times = np.arange(2 * SPEECH_RATE) / SPEECH_RATE
    clicks = np.zeros(len(times))
    for at in range(2000, len(times), 6000):
        clicks[at : at + 800] = rng.normal(0, 0.4, 800) * np.exp(-np.arange(800) / 120)
    for sound in (rng.normal(0, 0.05, len(times)), 0.1 * np.sin(2 * np.pi * 1000 * times), clicks, 0 * times):
        assert (judged(sound.astype(np.float32)) > 0.5).mean() < 0.02


@pytest.mark.parametrize("name", ["jfk.flac", "asterisk_fr_priv-callee-options.wav", "librivox_sense_0870.wav"])
def test_recorded_speech_is_a_voice(name: str) -> None:
    sound = read(reference_speech() / name)[: 6 * SPEECH_RATE]
    found = judged(sound)
    levels = 10 * np.log10((sound[: len(found) * CHUNK].reshape(-1, CHUNK) ** 2).mean(axis=1) + 1e-12)
    assert (found[levels > levels.max() - 30] > 0.5).mean() > 0.9


def test_how_loud_a_voice_is_does_not_matter() -> None:
    sound = read(reference_speech() / "librivox_sense_0870.wav")[: 4 * SPEECH_RATE]
    loud = judged(sound)
    for quieter_db in (20, 40):
        quiet = judged(np.rint(sound * 10 ** (-quieter_db / 20) * 32768).astype(np.float32) / 32768)
        assert abs((quiet > 0.5).mean() - (loud > 0.5).mean()) < 0.05


def test_a_voice_remains_one_between_its_words() -> None:
    sound = read(reference_speech() / "librivox_sense_0870.wav")[: 3 * SPEECH_RATE]
    detector = VoiceActivityDetector()
    detector.update({1: sound})
    before = detector.speech(1)
    assert before > 0.7
    pause = np.random.default_rng(4).normal(0, 1e-3, SPEECH_RATE // CHUNK * CHUNK).astype(np.float32)
    detector.update({1: pause})
    assert detector.speech(1) > 0.5


def test_recorded_claps_and_dishes_are_none() -> None:
    folder = reference_speech() / "noise"
    assert judged(read(folder / "hydrogen_GMRockKit_HandClap.wav")).max() < 0.5
    assert (judged(read(folder / "doing_the_dishes.wav")[: 40 * SPEECH_RATE]) > 0.5).mean() < 0.01


def test_sources_are_judged_each_by_itself_together_or_apart() -> None:
    rng = np.random.default_rng(2)
    sounds = {track: rng.normal(0, 0.02 * track, 1300).astype(np.float32) for track in (1, 2, 3)}
    together = VoiceActivityDetector()
    together.update(sounds)
    for track, sound in sounds.items():
        alone = VoiceActivityDetector()
        for piece in np.split(sound, [200, 900]):
            alone.update({track: piece})
        assert together.speech(track) == pytest.approx(alone.speech(track), abs=1e-5)


def test_no_track_is_judged_before_a_chunk_was_heard_or_after_it_was_forgotten() -> None:
    detector = VoiceActivityDetector()
    assert math.isnan(detector.speech(1))
    detector.update({1: np.zeros(CHUNK - 1, np.float32), 2: np.zeros(CHUNK, np.float32)})
    assert math.isnan(detector.speech(1))
    assert 0 <= detector.speech(2) <= 1
    detector.update({1: np.zeros(1, np.float32)})
    assert 0 <= detector.speech(1) <= 1
    detector.keep([1])
    assert math.isnan(detector.speech(2))
    detector.reset()
    assert math.isnan(detector.speech(1))


def test_the_model_goes_with_its_licence() -> None:
    text = MODEL.with_name("SILERO_VAD.md").read_text(encoding="utf-8")
    assert "MIT License" in text
    assert "Copyright (c) 2020-present Silero Team" in text
    import hashlib

    assert hashlib.sha256(MODEL.read_bytes()).hexdigest() in text
