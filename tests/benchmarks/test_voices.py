"""What the benchmark of voices counts, on a scene whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.voice_rooms import BOX, HELD_OUT, RATE, TUNING, Scene, Talker, draw, recipes
from benchmarks.voice_scoring import Located, score, to_line

FRONT, LEFT, UP = np.eye(3)


@pytest.fixture
def scene() -> Scene:
    """One second of silence before a talker in front who speaks from 0.4 s on."""
    active = np.arange(100) >= 40
    talker = Talker("", np.zeros(1), FRONT[None], 1.5, active)
    alone = np.where(np.arange(RATE) < 0.4 * RATE, 0, 0.1).astype(np.float32)[None]
    hiss = np.random.default_rng(1).normal(0, 0.01, (RATE, 8)).astype(np.float32)
    return Scene("", RATE, BOX, alone.T + hiss, alone, (talker,))


def found(direction: np.ndarray, begin_s: float) -> Located:
    return [(k / 50, k / 50, {7: direction} if k / 50 >= begin_s else {}) for k in range(1, 51)]


def test_recall_error_and_latency_are_counted_from_speech_on(scene: Scene) -> None:
    tilted = np.array([np.cos(0.05), np.sin(0.05), 0])
    scored = score(scene, found(tilted, 0.6), 3.0)
    assert scored.asked == 50  # from half a second on
    assert scored.found == pytest.approx(40, abs=1)
    assert scored.errors_deg == pytest.approx(np.degrees(0.05))
    assert scored.latencies_s[0] == pytest.approx(0.2, abs=0.02)
    assert scored.numbers == (1,)
    assert scored.false_s == ()
    assert scored.cpu_percent == 3.0


def test_what_is_weaker_than_the_noise_is_no_onset(scene: Scene) -> None:
    breath = scene.alone.copy()
    breath[:, round(0.4 * RATE) : round(0.5 * RATE)] = 0.001
    breathing = replace(scene, alone=breath, samples=scene.samples - scene.alone.T + breath.T)
    assert score(breathing, found(FRONT, 0.6), 0.0).latencies_s[0] == pytest.approx(0.1, abs=0.02)
    assert score(breathing, found(FRONT, 0.2), 0.0).latencies_s[0] == 0


def test_a_track_of_no_talker_is_false_for_as_long_as_it_lasts(scene: Scene) -> None:
    scored = score(scene, found(LEFT, 0.0), 0.0)
    assert scored.found == 0
    assert scored.false_s == (pytest.approx(1.0),)
    assert np.isinf(scored.latencies_s[0])


def test_microphones_on_a_line_are_asked_for_its_cone_alone(scene: Scene) -> None:
    assert score(scene, found(-FRONT, 0.0), 0.0, to_line(LEFT)).found == 50
    assert score(scene, found(UP, 0.0), 0.0, to_line(LEFT)).errors_deg == pytest.approx(0)


def test_scenes_are_drawn_by_their_seeds_and_tuning_shares_no_speaker_with_the_rest() -> None:
    one, other = recipes(HELD_OUT, 3, 0.3, 20.0, 2)
    assert draw(one).files == draw(one).files
    assert not np.array_equal(draw(one).size, draw(other).size)
    assert not set(sum(TUNING.speakers.values(), ())) & set(sum(HELD_OUT.speakers.values(), ()))
    azimuths = [np.degrees(np.arctan2(*(path[0] - draw(one).middle)[1::-1])) for path in draw(one).paths]
    apart = [abs((a - b + 180) % 360 - 180) for k, a in enumerate(azimuths) for b in azimuths[:k]]
    assert min(apart) >= 40


def test_walkers_go_120_degrees_past_one_another() -> None:
    walk = draw(recipes(HELD_OUT, 2, 0.3, 20.0, 1, walking=True)[0])
    for path in walk.paths:
        ends = [path[0] - walk.middle, path[-1] - walk.middle]
        cos = ends[0][:2] @ ends[1][:2] / np.linalg.norm(ends[0][:2]) / np.linalg.norm(ends[1][:2])
        assert np.degrees(np.arccos(cos)) == pytest.approx(120, abs=0.1)
