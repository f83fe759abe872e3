from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.separation import Separator, SeparatorSettings
from tests.modules.perception.voices.sounds import ARRAY, RATE, babble, heard, toward
from tests.scenery.bss_eval import bss_eval


def separate(
    separator: Separator, sound: NDArray[np.float32], sources: list[tuple[int, NDArray[np.float64]]]
) -> NDArray[np.float32]:
    blocks = range(0, len(sound) - separator.step + 1, separator.step)
    return np.concatenate([separator.process(sound[b : b + separator.step], sources).samples for b in blocks])


@pytest.fixture(scope="module")
def mixture() -> tuple[NDArray[np.float32], NDArray[np.float32], list[NDArray[np.float64]]]:
    directions = [toward(20), toward(-70)]
    images = [heard(babble(seed, 4.0), direction) for seed, direction in enumerate(directions)]
    noise = np.random.default_rng(9).normal(0, 2e-3, images[0].shape)
    mixed = np.asarray(sum(images) + noise, np.float32)
    return mixed, np.stack([image[::3, 0] for image in images]), directions


def test_two_voices_come_apart(
    mixture: tuple[NDArray[np.float32], NDArray[np.float32], list[NDArray[np.float64]]],
) -> None:
    mixed, references, directions = mixture
    separated = separate(Separator(ARRAY, RATE), mixed, list(enumerate(directions)))
    references = references[:, : len(separated)]
    before = bss_eval(references, np.stack([mixed[::3, 0]] * 2)[:, : len(separated)], taps=64)
    after = bss_eval(references, separated.T, taps=64)
    assert before.sir.mean() < 2
    assert after.order == (0, 1), "each under its own track"
    assert after.sir.min() > 13
    assert after.sdr.min() > 8


def test_what_comes_out_is_the_sound_of_the_reference_microphone_at_its_own_time() -> None:
    sound = heard(babble(3, 2.0), toward(60))
    separated = separate(Separator(ARRAY, RATE), sound, [(7, toward(60))])
    tail = slice(8_000, len(separated))
    assert np.corrcoef(separated[tail, 0], sound[::3, 0][tail])[0, 1] > 0.98
    assert 0.8 < separated[tail, 0].std() / sound[::3, 0][tail].std() < 1.1


@given(counts=st.lists(st.integers(0, 3), min_size=1, max_size=6))
@settings(max_examples=15, deadline=None)
def test_sample_numbers_follow_talkers_that_come_and_go(counts: list[int]) -> None:
    separator = Separator(ARRAY, RATE, SeparatorSettings(frame=256, frames=2))
    sound = np.random.default_rng(1).normal(0, 0.01, (separator.step, 8)).astype(np.float32)
    following, before = 0, 0
    for count in counts:
        block = separator.process(sound, [(number, toward(60 * number)) for number in range(count)])
        assert block.first_sample == following
        assert block.tracks[: min(count, 2)] == tuple(range(min(count, 2)))
        assert len(block.tracks) == max(min(count, 2), min(before, 2)), "one that left fades out"
        assert np.isfinite(block.samples).all()
        following, before = following + len(block.samples), count
    assert following == len(counts) * separator.step // 3 - 128, "half a frame behind"


def test_silence_stays_silence_and_a_reset_forgets() -> None:
    separator = Separator(ARRAY, RATE)
    silent = np.zeros((separator.step, 8), np.float32)
    assert not separator.process(silent, [(1, toward(0)), (2, toward(90))]).samples.any()
    sound = heard(babble(5, 1.0), toward(0))[: separator.step]
    first = Separator(ARRAY, RATE).process(sound, [(1, toward(0))])
    separator.process(sound, [(1, toward(0))])
    separator.reset()
    again = separator.process(sound, [(1, toward(0))])
    assert again.first_sample == 0
    np.testing.assert_array_equal(again.samples, first.samples)


@pytest.mark.parametrize(("rate", "output_rate"), [(16_000, 16_000), (44_100, 22_050), (96_000, 16_000)])
def test_rates(rate: int, output_rate: int) -> None:
    separator = Separator(ARRAY, rate)
    assert separator.output_rate == output_rate
    sound = heard(babble(3, 2.0, rate), toward(60), rate)
    separated = separate(separator, sound, [(1, toward(60))])
    aligned = sound[:: rate // output_rate, 0][: len(separated)]
    assert np.corrcoef(separated[4000:, 0], aligned[4000:])[0, 1] > 0.95


def test_what_it_refuses() -> None:
    with pytest.raises(ValueError, match="at least 16000 samples a second"):
        Separator(ARRAY, 8000)
    separator = Separator(ARRAY, RATE)
    with pytest.raises(ValueError, match=r"\(6144, 8\), not \(100, 8\)"):
        separator.process(np.zeros((100, 8), np.float32), [])
