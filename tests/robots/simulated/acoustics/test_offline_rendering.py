"""Rendered scenes: what the live microphones would hear, with the truth beside it."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.activity import activity
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, BaffledMicrophones
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox, response
from tests.robots.simulated.acoustics.decay import reverberation_time

RATE = 48000
ROOM = Shoebox((0.0, 0.0, 0.0), (6.0, 5.0, 3.0), (0.4, 0.4))
X_WA = Pose3.from_translation_rpy((2.0, 1.2, 1.0), (0.0, 0.0, 0.4))
IMPULSE = np.eye(1, 16, dtype=np.float32)[0]


def test_block_by_block_an_impulse_gives_the_rooms_response(shaded: BaffledMicrophones) -> None:
    place = (4.0, 2.2, 1.6)
    samples, _ = render_scene([OfflineSource(IMPULSE, place, begin_s=0.1)], X_WA, ROOM, 1.0, shaded)
    at_once = response(ROOM, place, X_WA, shaded, 0.9)
    begin = round(0.1 * RATE)
    early = samples[:, begin : begin + 2400] - at_once[:, :2400]
    assert np.sqrt(np.sum(early**2) / np.sum(at_once[:, :2400] ** 2)) < 0.1  # reflections have shortened tables
    assert reverberation_time(samples[:, begin:], RATE) == pytest.approx(0.4, rel=0.15)


def test_truth_is_where_and_when_the_sound_arrives(free: BaffledMicrophones) -> None:
    burst = np.concatenate([np.ones(4800), np.zeros(9600), np.ones(4800)]).astype(np.float32)
    source = OfflineSource(burst, lambda t: (4.0, 1.2 + t, 1.0), begin_s=0.2)
    _, (truth,) = render_scene([source], X_WA, None, 1.0, free)
    np.testing.assert_allclose(np.linalg.norm(truth.directions, axis=1), 1.0)
    np.testing.assert_allclose(truth.directions[0], [np.cos(0.4), -np.sin(0.4), 0.0], atol=1e-9)
    delay = truth.ranges_m[20] / SPEED_OF_SOUND_MPS
    heard = truth.times_s[truth.active]
    assert 0.2 + delay <= heard[0] <= 0.2 + delay + 0.011
    gap = truth.active[(truth.times_s > 0.2 + delay + 0.12) & (truth.times_s < 0.2 + delay + 0.28)]
    assert not gap.any()
    assert truth.active[(truth.times_s > 0.2 + delay + 0.31) & (truth.times_s < 0.2 + delay + 0.39)].all()


def test_pauses_shorter_than_a_twentieth_of_a_second_are_no_pauses() -> None:
    sound = np.ones(48000, dtype=np.float32)
    sound[9600 : 9600 + 1440] = 0
    sound[24000 : 24000 + 4800] = 0
    active = activity(sound, RATE)
    assert active[:50].all()
    assert not active[51:59].any()


def test_noise_is_as_strong_as_asked_and_unlike_at_each_microphone(free: BaffledMicrophones) -> None:
    samples, _ = render_scene([], X_WA, ROOM, 0.5, free, noise=0.01)
    np.testing.assert_allclose(samples.std(1), 0.01, rtol=0.05)
    assert abs(np.asarray(np.corrcoef(samples))[0, 1]) < 0.05
