"""Arrival times of a clap, to parts of a sample."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.perception.voices.array_calibration.arrival_times import arrivals_of, fit
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND
from tests.modules.perception.voices.array_calibration.clap_sounds import CORNERS, around, clap_of, heard_at, ways

LONGEST_S = 0.7 / SPEED_OF_SOUND


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 1000))
def test_arrival_times_are_exact_to_a_microsecond(seed: int) -> None:
    (source,) = around(1, seed)
    microphones = CORNERS + np.random.default_rng(seed).normal(0, 0.02, CORNERS.shape)
    arrivals = arrivals_of(clap_of(heard_at(source, microphones, seed)), LONGEST_S)
    np.testing.assert_allclose(arrivals.times, ways(source[None], microphones)[0] / SPEED_OF_SOUND, atol=1e-6)
    assert arrivals.agreement.min() > 0.9
    assert not arrivals.reversed.any()


def test_noise_and_an_echo_right_after_it_cost_some_microseconds() -> None:
    (source,) = around(1, 3)
    sound = heard_at(source, CORNERS, 3, noise=4e-3)
    # A wall, 0.9 m farther than the direct way, that reflects half.
    sound += 0.5 * heard_at(source * 1.6, CORNERS, 3, noise=0)
    arrivals = arrivals_of(clap_of(sound), LONGEST_S)
    np.testing.assert_allclose(arrivals.times, ways(source[None], CORNERS)[0] / SPEED_OF_SOUND, atol=4e-6)


def test_reversed_and_unrelated_channels() -> None:
    (source,) = around(1, 4)
    sound = heard_at(source, CORNERS, 4)
    sound[:, 2] *= -1
    sound[:, 5] = np.random.default_rng(0).normal(0, 0.01, len(sound))
    arrivals = arrivals_of(clap_of(sound), LONGEST_S)
    assert arrivals.reversed[2]
    assert not arrivals.reversed[[0, 1, 3, 4, 6, 7]].any()
    assert arrivals.agreement[5] < 0.3 < 0.7 < np.delete(arrivals.agreement, 5).min()
    others = [channel for channel in range(8) if channel != 5]
    expected = ways(source[None], CORNERS[others])[0] / SPEED_OF_SOUND
    times = arrivals.times[others]
    np.testing.assert_allclose(times - times.mean(), expected, atol=2e-6)


def test_powers_are_those_of_sound_without_noise() -> None:
    (source,) = around(1, 5)
    quiet, loud = (arrivals_of(clap_of(heard_at(source, CORNERS, 5) * gain), LONGEST_S) for gain in (1.0, 2.0))
    for name in ("direct", "tail", "noise"):
        np.testing.assert_allclose(getattr(loud, name), 4 * getattr(quiet, name), rtol=1e-3)
    assert quiet.noise == pytest.approx(1e-8, rel=0.2)
    without = arrivals_of(clap_of(heard_at(source, CORNERS, 5, tail=0)), LONGEST_S)
    assert without.tail.max() < 0.05 * quiet.tail.min()


@settings(deadline=None)
@given(st.integers(3, 12), st.integers(0, 10_000))
def test_a_wrong_lag_does_not_move_the_arrival_times(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = rng.uniform(-5e-4, 5e-4, count)
    first, second = np.triu_indices(count, 1)
    lags = times[first] - times[second]
    heights = np.ones(len(lags))
    np.testing.assert_allclose(fit(lags, heights, count), times - times.mean(), atol=1e-9)
    # Of three microphones with one wrong lag, each two of the lags are as likely.
    if count > 4:
        lags[rng.integers(len(lags))] += rng.choice([-1, 1]) * rng.uniform(2e-4, 1e-3)
        np.testing.assert_allclose(fit(lags, heights, count), times - times.mean(), atol=1e-6)
