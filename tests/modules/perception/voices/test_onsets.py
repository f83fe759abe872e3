"""The precedence effect: what begins comes from its source, and an echo does not begin."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.localization import Localizer
from app.modules.perception.voices.onsets import Onsets
from tests.modules.perception.voices.sounds import ARRAY, RATE, babble, heard, toward


def leads(sound: NDArray[np.float32], *directions: NDArray[np.float64]) -> list[float]:
    """How much better what begins agrees with each of ``directions`` than all that sounds."""
    localizer = Localizer(ARRAY, RATE)
    total = np.zeros((len(directions), 4))
    for end in range(localizer.step, len(sound) + 1, localizer.step):
        peaks = localizer.process(sound[end - localizer.step : end], np.array(directions))
        for number, direction in enumerate(directions):
            near = peaks.directions @ direction
            if near.max(initial=-1.0) > 0.98:
                total[number] += peaks.onsets[near.argmax()]
    return [float(rising * most / (most_rising * sum_)) for rising, sum_, most_rising, most in total]


@pytest.mark.parametrize("late_ms", [8, 20])
def test_an_echo_does_not_lead_and_a_second_talker_does(late_ms: int) -> None:
    rng = np.random.default_rng(late_ms)
    front, aside = toward(20), toward(-100)
    late = RATE * late_ms // 1000
    talk, other = babble(1, 3.0), babble(2, 3.0)
    echo = np.concatenate([np.zeros(late, np.float32), talk[:-late]])
    noise = rng.normal(0, 1e-4, (len(talk), len(ARRAY))).astype(np.float32)
    talker, wall = leads(heard(talk, front) + 0.7 * heard(echo, aside) + noise, front, aside)
    _, second = leads(heard(talk, front) + 0.7 * heard(other, aside) + noise, front, aside)
    assert talker > wall + 0.15
    assert second > wall + 0.15


def test_agreement_is_full_for_what_all_microphones_hear_alike() -> None:
    onsets = Onsets()
    phases = np.ones((2, 4, 3), np.complex64)
    weights = np.ones((2, 3), np.float32)
    powers = np.array([[1.0, 1.0, 1.0], [1.0, 2.0, 4.0]], np.float32)
    onsets.update(phases, powers, weights)
    alike = np.ones((1, 4, 3), np.complex64)
    unlike = np.tile(np.array([1, -1, 1, -1], np.complex64)[:, None], (1, 1, 3))
    rising, all_, most_rising, most = onsets.agreement(np.concatenate([alike, unlike])).T
    # The first frame follows nothing and begins nothing; of the second, half of one and three quarters of another.
    np.testing.assert_allclose(most_rising, 1.25, rtol=1e-6)
    np.testing.assert_allclose(most, 6.0, rtol=1e-6)
    np.testing.assert_allclose(rising, [1.25, -1.25 / 3], rtol=1e-5)
    np.testing.assert_allclose(all_, [6.0, -2.0], rtol=1e-5)


def test_frames_follow_one_another_until_the_past_is_forgotten() -> None:
    onsets = Onsets()
    one = np.ones((1, 2, 1), np.complex64)
    for power, rising in ((1.0, 0.0), (4.0, 0.75), (2.0, 0.0)):
        onsets.update(one, np.full((1, 1), power, np.float32), np.ones((1, 1), np.float32))
        assert onsets.agreement(one)[0, 2] == pytest.approx(rising)
    onsets.reset()
    onsets.update(one, np.full((1, 1), 8.0, np.float32), np.ones((1, 1), np.float32))
    assert onsets.agreement(one)[0, 2] == 0
