"""Utterances out of the sound of all microphones: their limits, direction and sound."""

from __future__ import annotations

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray
from scipy.signal import resample_poly

from app.modules.perception.words.utterance_beam import RATE as WORD_RATE
from app.modules.perception.words.utterance_beam import UtteranceBeam
from app.modules.perception.words.utterance_listener import HeardUtterance, UtteranceListener
from app.robots.simulated.acoustics.sound_library import SPEECH
from tests.modules.perception.voices.sounds import ARRAY, RATE, as_int16, heard, toward


def speech(begin_s: float, seconds: float, file: str = "kennedy_1") -> NDArray[np.float32]:
    """Recorded speech at RATE, its loudest sample 0.2."""
    sound, rate = soundfile.read(SPEECH / f"{file}.flac", dtype="float32")
    part = sound[round(begin_s * rate) : round((begin_s + seconds) * rate)]
    whole = resample_poly(part, RATE, rate).astype(np.float32)
    return np.asarray(0.2 * whole / np.abs(whole).max(), np.float32)


def quiet(seconds: float) -> NDArray[np.float32]:
    return np.zeros(round(seconds * RATE), np.float32)


def noisy(sound: NDArray[np.float32], level: float = 0.002) -> NDArray[np.float32]:
    return sound + np.random.default_rng(3).normal(0, level, sound.shape).astype(np.float32)


def listened(
    sound: NDArray[np.float32], size: int = 3072, first: int = 0, longest_s: float = 2.5
) -> list[HeardUtterance]:
    listener = UtteranceListener(ARRAY, RATE, longest_s)
    samples = as_int16(sound)
    found = []
    for at in range(0, len(samples), size):
        found += listener.process(samples[at : at + size], first + at)
    return found


def angle_deg(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.fixture(scope="module")
def two() -> tuple[NDArray[np.float32], float]:
    """An utterance of 0.8 s from the left after 1 s, another from behind to the right; and where the second begins."""
    left = heard(np.concatenate([quiet(1.0), speech(0.6, 0.8), quiet(3.0)]), toward(70))
    right = heard(np.concatenate([quiet(3.0), speech(0.5, 0.9, "austen_1"), quiet(0.9)]), toward(-130))
    length = min(len(left), len(right))
    return noisy(left[:length] + right[:length]), 3.0


def test_utterances_have_their_limits_and_directions(two: tuple[NDArray[np.float32], float]) -> None:
    sound, second_s = two
    found = listened(sound, first=480_000)
    assert len(found) == 2
    for utterance, begin_s, seconds, azimuth in zip(found, (1.0, second_s), (0.8, 0.9), (70, -130), strict=True):
        begin, end = (utterance.begin - 480_000) / RATE, (utterance.end - 480_000) / RATE
        assert begin_s - 0.35 < begin < begin_s + 0.35
        assert begin_s + seconds - 0.3 < end < begin_s + seconds + 0.45
        assert len(utterance.samples) == pytest.approx((end - begin) * WORD_RATE, abs=2)
        assert angle_deg(utterance.direction, toward(azimuth)) < 8
        assert np.abs(utterance.samples).max() == pytest.approx(16384, abs=2)


def test_how_the_sound_is_cut_into_frames_does_not_matter(two: tuple[NDArray[np.float32], float]) -> None:
    sound, _ = two
    whole, pieces = listened(sound, size=len(sound)), listened(sound, size=700)
    assert [(u.begin, u.end) for u in whole] == [(u.begin, u.end) for u in pieces]
    for one, other in zip(whole, pieces, strict=True):
        assert np.array_equal(one.direction, other.direction)


def test_talk_is_left_out() -> None:
    talk = heard(np.concatenate([quiet(1.0), speech(0.0, 4.0), quiet(1.0)]), toward(20))
    assert listened(noisy(talk), longest_s=1.0) == []


def test_after_a_reset_the_past_is_forgotten(two: tuple[NDArray[np.float32], float]) -> None:
    sound, _ = two
    listener = UtteranceListener(ARRAY, RATE, 2.5)
    middle = round(1.4 * RATE)
    assert listener.process(as_int16(sound[:middle]), 0) == []
    listener.reset()
    later = round(2.2 * RATE)
    (found,) = listener.process(as_int16(sound[later:]), later)
    assert found.begin > later


def test_a_beam_of_all_microphones_has_less_noise_than_one() -> None:
    dry = np.concatenate([speech(0.6, 1.2), quiet(0.1)])
    clean = resample_poly(heard(dry, toward(40)), WORD_RATE, RATE, axis=0).astype(np.float32)
    rng = np.random.default_rng(4)
    level = float(clean.std())
    before = rng.normal(0, level, (WORD_RATE, 8)).astype(np.float32)
    sound = clean + rng.normal(0, level, clean.shape).astype(np.float32)
    focused = UtteranceBeam(ARRAY).focus(sound, before)
    assert angle_deg(focused.direction, toward(40)) < 8

    def ratio_db(heard_sound: NDArray[np.float32]) -> float:
        """Of what is linear in the clean sound, at its best delay, to the rest."""
        size = 2 * len(heard_sound)
        cross = np.fft.irfft(np.fft.rfft(heard_sound, size) * np.fft.rfft(clean[:, 0], size).conj())
        alike = float(np.max(cross) ** 2 / ((heard_sound**2).sum() * (clean[:, 0] ** 2).sum()))
        return 10 * np.log10(alike / (1 - alike))

    assert ratio_db(focused.samples) > ratio_db(sound[:, 0]) + 8


def test_sound_of_a_low_rate_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 16000 samples a second, not 8000"):
        UtteranceListener(ARRAY, 8000, 2.0)
