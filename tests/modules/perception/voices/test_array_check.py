"""Whether the microphones are where they are said to be: by what they hear, without any truth."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.array_check import LEAST_MOMENTS, MOST_MOMENTS, ArrayCheck
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND
from tests.modules.perception.voices.sounds import ARRAY, CORNERS, RATE, as_int16, babble, heard, toward

FREQUENCIES = np.arange(200.0, 7000.0, 46.875)


@pytest.fixture(scope="module")
def two_talkers() -> NDArray[np.int16]:
    """4 s of two talkers at once in noise, as ARRAY hears them."""
    sound = heard(babble(0, 4.0), toward(60)) + heard(babble(1, 4.0), toward(-75, 5))
    return as_int16(sound + np.random.default_rng(1).normal(0, 3e-3, sound.shape))


def checked(sound: NDArray[np.int16], array: MicrophoneArray) -> ArrayCheck:
    pipeline = VoicePipeline(array, RATE, PipelineSettings(separation=False, speech=False))
    for begin in range(0, len(sound) - pipeline.step + 1, pipeline.step):
        pipeline.process(sound[begin : begin + pipeline.step], begin / RATE, begin)
    return pipeline.array_check


def spectra(delays_s: NDArray[np.float64]) -> NDArray[np.complex64]:
    """Cross spectra of one sound that comes to each microphone so late (M,)."""
    first, second = np.triu_indices(len(delays_s), 1)
    return np.exp(-2j * np.pi * (delays_s[first] - delays_s[second])[:, None] * FREQUENCIES).astype(np.complex64)


def test_right_positions_explain_what_two_talkers_say(two_talkers: NDArray[np.int16]) -> None:
    check = checked(two_talkers, ARRAY)
    assert check.moments >= LEAST_MOMENTS
    assert check.share > 0.9
    assert not check.failed


@pytest.mark.parametrize(
    ("wrong", "positions"),
    [
        ("two swapped", CORNERS[[1, 0, 2, 3, 4, 5, 6, 7]]),
        ("shifted by one", np.roll(CORNERS, 1, axis=0)),
        ("two rows for one another, one turned", CORNERS[[5, 6, 7, 4, 0, 1, 2, 3]]),
        ("twice the size", 2 * CORNERS),
        ("half the size", CORNERS / 2),
    ],
)
def test_wrong_positions_do_not(two_talkers: NDArray[np.int16], wrong: str, positions: NDArray[np.float64]) -> None:
    check = checked(two_talkers, MicrophoneArray(positions))
    assert check.failed, wrong
    assert check.share < 0.7


def test_a_mirror_image_of_the_array_cannot_be_noticed(two_talkers: NDArray[np.int16]) -> None:
    check = checked(two_talkers, MicrophoneArray(CORNERS[[1, 0, 3, 2, 5, 4, 7, 6]]))
    assert not check.failed
    assert check.share > 0.9


def test_silence_and_noise_give_no_verdict() -> None:
    noise = np.random.default_rng(0).normal(0, 0.05, (2 * RATE, 8))
    for sound in (np.zeros((RATE, 8)), noise):
        check = checked(as_int16(sound), MicrophoneArray(np.roll(CORNERS, 1, axis=0)))
        assert (check.moments, check.failed, check.share) == (0, False, 1.0)


def test_one_clear_sound_is_agreed_on_wherever_the_microphones_are() -> None:
    check = ArrayCheck(ARRAY, FREQUENCIES, 1024 / RATE)
    rng = np.random.default_rng(2)
    for _ in range(5):
        direction = toward(rng.uniform(-180, 180), rng.uniform(-20, 60))
        right = check.agreement(spectra(-(CORNERS @ direction) / SPEED_OF_SOUND))
        # The nearest lags on a raster of 10 µs, and waves taken as spheres.
        assert right.agreed > 0.9
        assert right.explained > 0.85
        anything = check.agreement(spectra(rng.uniform(-5e-4, 5e-4, 8)))
        assert anything.agreed > 0.9
        assert anything.explained < 0.6


def test_of_a_pair_only_what_comes_too_late_for_its_size_can_be_noticed() -> None:
    pair = MicrophoneArray(np.array([[0, 0.05, 0], [0, -0.05, 0]]))
    check = ArrayCheck(pair, FREQUENCIES, 1024 / RATE)
    within, beyond = (check.agreement(spectra(np.array([0.0, late]))) for late in (0.08 / 343, 0.2 / 343))
    assert within.explained > 0.95 * within.agreed
    assert beyond.agreed > 0.9
    assert beyond.explained < 0.3


def test_small_arrays_must_explain_more() -> None:
    cross = 0.032 * np.array([(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0)])
    direction = toward(10)
    right = ArrayCheck(MicrophoneArray(cross), FREQUENCIES, 1024 / RATE)
    swapped = ArrayCheck(MicrophoneArray(cross[[0, 2, 1, 3]]), FREQUENCIES, 1024 / RATE)
    for check in (right, swapped):
        for _ in range(LEAST_MOMENTS):
            check.update(spectra(-(cross @ direction) / SPEED_OF_SOUND))
    assert right.least_share == 0.9
    assert not right.failed
    assert swapped.failed


def test_it_hears_no_more_than_enough() -> None:
    check = ArrayCheck(ARRAY, FREQUENCIES, 1024 / RATE)
    right, wrong = spectra(-(CORNERS @ toward(10)) / SPEED_OF_SOUND), spectra(np.linspace(0, 1e-3, 8) ** 2 * 1e3)
    for _ in range(MOST_MOMENTS):
        assert not check.done
        check.update(right)
    assert check.done
    share = check.share
    check.update(wrong)
    assert (check.moments, check.share) == (MOST_MOMENTS, share)
