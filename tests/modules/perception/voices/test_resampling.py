from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import firwin, resample_poly

from app.modules.perception.voices.resampling import Resampler, low_pass, resampled


@pytest.mark.parametrize("rate", [16_000, 22_050, 44_100, 48_000, 96_000])
def test_a_tone_keeps_its_pitch_size_and_time_and_what_cannot_be_reported_is_left_out(rate: int) -> None:
    resampler = Resampler(rate, 16_000)
    times = np.arange(rate // 2) / rate
    out = resampler.process(np.sin(2 * np.pi * 1000 * times).astype(np.float32))
    expected = np.sin(2 * np.pi * 1000 * (np.arange(len(out)) / 16_000 - resampler.delay_s))
    np.testing.assert_allclose(out[300:-300], expected[300:-300], atol=1e-3)
    if rate > 18_000:
        resampler.reset()
        above = resampler.process(np.sin(2 * np.pi * 9000 * times).astype(np.float32))
        assert above[300:].std() < 1e-3


@given(st.lists(st.integers(0, 700), max_size=8), st.sampled_from([44_100, 48_000, 32_000, 16_000]))
@settings(max_examples=30, deadline=None)
def test_pieces_make_the_same_sound_as_the_whole(pieces: list[int], rate: int) -> None:
    sound = np.random.default_rng(1).normal(0, 0.1, sum(pieces)).astype(np.float32)
    resampler = Resampler(rate, 16_000)
    parts = [resampler.process(piece) for piece in np.split(sound, np.cumsum(pieces)[:-1])] if pieces else []
    whole = Resampler(rate, 16_000).process(sound)
    np.testing.assert_allclose(np.concatenate([whole[:0], *parts]), whole, atol=1e-6)


@pytest.mark.parametrize(("taps", "cutoff", "beta"), [(72, 0.31, 6.0), (61, 1 / 3, 5.0)])
def test_a_low_pass_is_the_one_that_scipy_makes(taps: int, cutoff: float, beta: float) -> None:
    expected = firwin(taps, cutoff, window=("kaiser", beta))
    np.testing.assert_allclose(low_pass(taps, cutoff, beta), expected, atol=1e-12)


@pytest.mark.parametrize("rate", [16_000, 22_050, 32_000, 44_100, 48_000])
@pytest.mark.parametrize("count", [0, 1, 100, 5000])
def test_a_whole_sound_is_resampled_as_scipy_does(rate: int, count: int) -> None:
    sound = np.random.default_rng(1).normal(0, 0.1, (count, 2)).astype(np.float32)
    found = resampled(sound, rate, 16_000)
    assert found.dtype == np.float32
    if count:
        np.testing.assert_allclose(found, resample_poly(sound, 16_000, rate, axis=0), atol=1e-6)
    else:
        assert found.shape == (0, 2)
