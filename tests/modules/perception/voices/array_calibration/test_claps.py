"""Claps found in sound that comes block by block."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.claps import Clap, ClapDetector
from tests.modules.perception.voices.array_calibration.clap_sounds import CROSS, RATE, around, recording
from tests.modules.perception.voices.sounds import as_int16, babble

SOUND = recording(around(4, 1), CROSS, 1)


def found(sound: NDArray[np.int16], lengths: list[int], rate: int = RATE) -> list[Clap]:
    """The claps in ``sound`` given in blocks of ``lengths``, over and over."""
    detector = ClapDetector(rate, sound.shape[1])
    claps, begin, number = [], 0, 0
    while begin < len(sound):
        length = lengths[number % len(lengths)]
        claps += detector.process(sound[begin : begin + length])
        begin, number = begin + length, number + 1
    return claps


IN_BLOCKS = found(SOUND, [512])


def test_each_clap_is_found_once_at_its_onset() -> None:
    claps = IN_BLOCKS
    # Each leaves the hands 0.2 s after the last piece began, and travels for 3 to 6 ms.
    assert [clap.at_s for clap in claps] == pytest.approx([0.2045 + 0.45 * k for k in range(4)], abs=0.003)
    for clap in claps:
        begin = round(clap.at_s * RATE) - clap.onset
        np.testing.assert_array_equal(clap.sound, SOUND[begin : begin + len(clap.sound)].astype(np.float32) / 32768)
        assert not clap.clipped


@settings(deadline=None, max_examples=8)
@given(st.lists(st.integers(200, 9000), min_size=1, max_size=4))
def test_the_lengths_of_blocks_change_nothing(lengths: list[int]) -> None:
    for clap, other in zip(found(SOUND, lengths), IN_BLOCKS, strict=True):
        # The background is that of what was there when a hop was looked at.
        assert clap.at_s == pytest.approx(other.at_s, abs=0.0021)


@pytest.mark.parametrize("rate", [16_000, 44_100])
def test_other_rates(rate: int) -> None:
    assert len(found(recording(around(3, 2), CROSS, 2, rate=rate), [512], rate)) == 3


def test_what_lasts_or_rises_slowly_is_no_clap() -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 1e-4, (RATE, 4))
    lasting = noise.copy()
    lasting[RATE // 2 :] += rng.normal(0, 0.05, (RATE // 2, 4))
    rising = noise + 0.1 * np.linspace(0, 1, RATE)[:, None] ** 4 * rng.standard_normal((RATE, 4))
    talk = np.repeat(babble(3, 3.0)[:, None], 4, axis=1) + rng.normal(0, 1e-4, (3 * RATE, 4))
    for sound in (noise, lasting, rising, np.zeros((RATE, 4)), talk):
        assert found(as_int16(sound), [512]) == []


def test_lost_sound_is_no_clap_and_times_go_on() -> None:
    detector = ClapDetector(RATE, 4)
    detector.process(SOUND[: RATE // 5])
    detector.restart(RATE)
    claps = [clap for begin in range(0, len(SOUND), 512) for clap in detector.process(SOUND[begin : begin + 512])]
    assert [clap.at_s for clap in claps] == pytest.approx([1.4045 + 0.45 * k for k in range(4)], abs=0.003)


def test_full_scale_is_noted() -> None:
    (clap, *_) = found(as_int16(20 * SOUND.astype(np.float64) / 32768), [512])
    assert clap.clipped
