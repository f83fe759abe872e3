"""Faults of microphones, and gains, by what claps are at them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.modules.perception.voices.array_calibration.arrival_times import Arrivals
from app.modules.perception.voices.array_calibration.faults import Fault, faults_of, gains_db
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND
from tests.modules.perception.voices.array_calibration.clap_sounds import CORNERS, around, ways


def heard(count: int = 12) -> list[Arrivals]:
    """What sound microphones at CORNERS hear of claps."""
    return [
        Arrivals(
            times, np.ones(8), np.zeros(8, bool), direct=np.full(8, 1e-3), tail=np.full(8, 1e-5), noise=np.full(8, 1e-8)
        )
        for times in ways(around(count, 1), CORNERS) / SPEED_OF_SOUND
    ]


def changed(name: str, channel: int, factor: float, count: int = 12) -> list[Arrivals]:
    """The same, ``name`` of one ``channel`` times ``factor``."""
    scale = np.where(np.arange(8) == channel, factor, 1.0)
    return [replace(one, **{name: getattr(one, name) * scale}) for one in heard(count)]


def test_sound_microphones_have_no_fault() -> None:
    assert faults_of(heard(), CORNERS) == [Fault()] * 8


@pytest.mark.parametrize(
    ("name", "factor", "words", "silences"),
    [
        ("direct", 0.0, "hears none of the claps", True),
        ("direct", 1e-4, "hears next to nothing: 40 dB below the median microphone", True),
        ("agreement", 0.3, "hears something else", True),
        ("noise", 100.0, "is noisy: 20 dB more noise", False),
    ],
)
def test_each_fault_is_named(name: str, factor: float, words: str, silences: bool) -> None:
    faults = faults_of(changed(name, 3, factor), CORNERS)
    assert faults[3].words.startswith(words)
    assert faults[3].silences == silences
    assert [channel for channel, fault in enumerate(faults) if fault.words] == [3]


def test_reversed_polarity_and_channels_that_are_one() -> None:
    faults = faults_of([replace(one, reversed=np.arange(8) == 6) for one in heard()], CORNERS)
    assert "reversed polarity" in faults[6].words
    assert not faults[6].silences
    doubled = [replace(one, times=one.times[[0, 1, 2, 3, 4, 2, 6, 7]]) for one in heard()]
    faults = faults_of(doubled, CORNERS)
    assert faults[5] == Fault("carries the same sound as channel 2", True)
    assert not faults[2].words


def test_gains_are_those_of_the_reverberation_or_else_of_the_direct_sound() -> None:
    gains = np.array([0, 1, -1, 2, 0, 0, -2, 0.5])
    factor = 10 ** (gains / 10)
    apart = np.linalg.norm(around(12, 1)[:, None] - CORNERS, axis=2)
    loud = [
        replace(one, tail=one.tail * factor * (1 + 0.01 * row), direct=factor / ways_**2)
        for row, (one, ways_) in enumerate(zip(heard(), apart, strict=True))
    ]
    found, deviations = gains_db(loud, apart)
    np.testing.assert_allclose(found, gains - np.median(gains), atol=1e-6)
    assert deviations.max() < 1e-6
    outdoors = [replace(one, tail=np.zeros(8)) for one in loud]
    np.testing.assert_allclose(gains_db(outdoors, apart)[0], gains - np.median(gains), atol=1e-6)
    found, _ = gains_db([replace(one, tail=one.tail * (np.arange(8) != 4)) for one in loud], apart)
    assert np.isnan(found[4])
    np.testing.assert_allclose(np.delete(found, 4), np.delete(gains, 4) - np.median(np.delete(gains, 4)), atol=1e-6)
