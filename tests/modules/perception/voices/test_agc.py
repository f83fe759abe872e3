from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.agc import AutomaticGain, GainSettings

RATE, PIECE = 16_000, 512


def db(sound: NDArray[np.float32]) -> float:
    return float(10 * np.log10((sound.astype(np.float64) ** 2).mean() + 1e-20))


def noise(level_db: float, seconds: float, seed: int = 1) -> NDArray[np.float32]:
    count = int(seconds * RATE) // PIECE * PIECE
    return (10 ** (level_db / 20) * np.random.default_rng(seed).standard_normal(count)).astype(np.float32)


def through(sound: NDArray[np.float32], gain: AutomaticGain | None = None) -> tuple[NDArray[np.float32], list[float]]:
    gain = gain or AutomaticGain(RATE)
    outputs = [gain.apply(piece) for piece in sound.reshape(-1, PIECE)]
    return np.concatenate([out for out, _ in outputs]), [below for _, below in outputs]


@given(st.floats(-60, -3))
def test_what_lasts_comes_to_the_level_wanted(level_db: float) -> None:
    out, below = through(noise(level_db, 0.5))
    assert db(out) == pytest.approx(GainSettings().target_db, abs=1)
    assert max(below) < 1.5


def test_it_makes_nothing_louder_than_it_may() -> None:
    out, _ = through(noise(-90, 0.5))
    assert db(out) == pytest.approx(-90 + GainSettings().most_db, abs=0.2)
    silent, _ = through(np.zeros(4 * PIECE, np.float32))
    assert not silent.any()


def test_pauses_are_not_raised_to_words() -> None:
    words, pause = noise(-30, 1.0), noise(-60, 0.6)
    gain = AutomaticGain(RATE)
    through(words, gain)
    quiet, below = through(pause, gain)
    # Six decibels a second at most, of the thirty between them.
    assert db(quiet) < GainSettings().target_db - 30 + 4
    assert min(below) > 25
    again, _ = through(words, gain)
    assert db(again) == pytest.approx(GainSettings().target_db, abs=1.5)


@given(st.lists(st.floats(-80, 0), min_size=1, max_size=20), st.integers(0, 9))
def test_no_sample_is_cut_off_whatever_comes(levels: list[float], seed: int) -> None:
    sound = np.concatenate([noise(level, PIECE / RATE, seed + at) for at, level in enumerate(levels)])
    out, below = through(np.clip(sound, -1, 1))
    assert np.abs(out).max() <= GainSettings().peak + 1e-6
    assert all(value >= 0 for value in below)
