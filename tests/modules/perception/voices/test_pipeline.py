from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.messages import SeparatedSound, SoundSources
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.acoustics.sound_library import ClipLibrary
from app.robots.stream_config import MicrophonesConfig
from tests.modules.perception.voices.sounds import ARRAY, RATE, as_int16, babble, heard, heard_turning, toward
from tests.scenery.bss_eval import bss_eval

#: As on the robot: the middle 0.8 m above the floor.
PLACED = MicrophoneArray(ARRAY.positions + np.array([0.0, 0.0, 0.8]))
Told = list[tuple[SoundSources, SeparatedSound | None]]


def run(pipeline: VoicePipeline, sound: NDArray[np.int16], turning: float = 0.0, first: int = 0) -> Told:
    """Feed it all; ``turning`` rad/s."""
    results = []
    for begin in range(0, len(sound) - pipeline.step + 1, pipeline.step):
        at = (first + begin) / RATE
        heading = turning * (pipeline.instant(at) - first / RATE)
        results.append(pipeline.process(sound[begin : begin + pipeline.step], at, first + begin, heading))
    return results


def noisy(sound: NDArray[np.float32]) -> NDArray[np.int16]:
    return as_int16(sound + np.random.default_rng(3).normal(0, 1e-3, sound.shape))


def degrees(a: tuple[float, float, float], b: NDArray[np.float64]) -> float:
    return math.degrees(math.acos(min(1.0, float(np.dot(a, b)))))


@pytest.fixture(scope="module")
def two() -> tuple[NDArray[np.float32], Told]:
    images = [heard(babble(seed, 4.0), toward(azimuth)) for seed, azimuth in ((0, 20), (1, -70))]
    sound = noisy(images[0] + images[1])
    return np.stack([image[::3, 0] for image in images]), run(VoicePipeline(PLACED, RATE), sound)


def test_two_voices_are_located_followed_and_given_each_by_itself(
    two: tuple[NDArray[np.float32], Told],
) -> None:
    references, results = two
    late = [sources for sources, _ in results[len(results) // 2 :]]
    for direction in (toward(20), toward(-70)):
        near = [[s for s in m.sources if degrees(s.direction, direction) < 5] for m in late]
        assert sum(map(bool, near)) > 0.95 * len(near)
        assert len({s.track for found in near for s in found}) == 1
    separated = [message for _, message in results if message is not None]
    length = separated[-1].first_sample + len(separated[-1].samples)
    voices = np.zeros((2, length))
    tracks = sorted({track for message in separated for track in message.tracks})[:2]
    for message in separated:
        assert message.rate == 16_000
        assert message.stamp == pytest.approx(message.first_sample / 16_000, abs=1e-9)
        for column, track in enumerate(message.tracks):
            if track in tracks:
                here = slice(message.first_sample, message.first_sample + len(message.samples))
                voices[tracks.index(track), here] = message.samples[:, column]
    spoken = slice(24_000, length)
    scores = bss_eval(references[:, spoken], voices[:, spoken], taps=64)
    assert scores.sir.min() > 13
    assert scores.sdr.min() > 5


def test_stamps_are_of_the_sound_and_sources_come_about_twenty_times_a_second(
    two: tuple[NDArray[np.float32], Told],
) -> None:
    _, results = two
    stamps = np.array([sources.stamp for sources, _ in results])
    assert 0 < stamps[0] < 2048 / RATE
    np.testing.assert_allclose(np.diff(stamps), 2048 / RATE)
    assert all(sources.p_BA == pytest.approx((0, 0, 0.8)) for sources, _ in results)


def test_levels_and_distances_are_those_of_a_standing_talker(
    two: tuple[NDArray[np.float32], Told],
) -> None:
    _, results = two
    for source in results[-1][0].sources:
        assert -60 < source.level_db < -15
        # A mouth at 1.53 m in the mean, seen from 0.8 m under 15 degrees.
        assert source.range_m == pytest.approx(0.73 / math.tan(math.radians(15)), rel=0.3)
        assert 0.2 < source.range_sigma_m < 1.5
        assert 0 <= source.speech <= 1


def test_a_turning_robot_keeps_a_still_source_as_one_track() -> None:
    turning = math.radians(50)
    sound = noisy(heard_turning(babble(0, 3.0), 60, 50))
    results = run(VoicePipeline(PLACED, RATE, PipelineSettings(separation=False, speech=False)), sound, turning)
    late = [sources for sources, _ in results[30:]]
    errors = []
    for message in late:
        if message.sources:
            now = toward(60 - 50 * message.stamp)
            errors.append(min(degrees(source.direction, now) for source in message.sources))
    assert len(errors) > 0.9 * len(late)
    assert np.median(errors) < 4
    assert all(math.isnan(source.speech) for message in late for source in message.sources)


def test_after_a_gap_what_is_still_heard_keeps_its_number_and_after_a_step_back_in_time_nothing_does() -> None:
    sound = noisy(heard(babble(0, 2.0), toward(20)))
    pipeline = VoicePipeline(PLACED, RATE, PipelineSettings(speech=False))
    before = run(pipeline, sound)[-1][0].sources
    pipeline.reset()
    after = run(pipeline, sound, first=len(sound) + 24_000)
    assert {s.track for s in before} & {s.track for s in after[-1][0].sources}
    separated = [message for _, message in after if message is not None]
    assert separated[0].first_sample >= (len(sound) + 24_000) // 3
    assert separated[0].stamp == pytest.approx(separated[0].first_sample / 16_000, abs=1e-4)
    newest = pipeline.next_track
    again = run(pipeline, sound)[-1][0].sources
    assert again
    assert all(source.track >= newest for source in again)


def test_subsets_take_their_own_columns_and_two_microphones_know_no_height() -> None:
    sound = noisy(heard(babble(0, 2.0), toward(50, 0)))
    pipeline = VoicePipeline(PLACED.subset(2), RATE, PipelineSettings(separation=False, speech=False), first_track=40)
    results = run(pipeline, sound)
    sources = [source for message, _ in results[-20:] for source in message.sources]
    assert sources
    assert all(source.track >= 40 for source in sources)
    assert min(abs(math.degrees(math.atan2(s.direction[1], s.direction[0])) - 50) for s in sources) < 6
    assert sources[-1].range_sigma_m > 1.5


@pytest.mark.parametrize("separation", [True, False])
def test_someone_who_says_hello_two_metres_away_is_a_voice_soon_and_until_he_ends(separation: bool) -> None:
    config = MicrophonesConfig()
    positions = np.array(config.positions) - np.mean(config.positions, axis=0)
    clip = ClipLibrary(RATE, config.sensitivity_db).get("hello")
    place = toward(30, 15) * 2.0 + (3, 2.6, 0.9)
    room = Shoebox((0.0, 0.0, 0.0), (7.0, 6.0, 3.0), (0.5, 0.4))
    sound, truths = render_scene(
        [OfflineSource(clip.samples, place, begin_s=0.5, looks="listener")],
        Pose3.from_translation_rpy((3.0, 2.6, 0.9)),
        room,
        clip.seconds + 0.6,
        BaffledMicrophones(positions, RATE, shadow=True),
        early_s=0.021,
        noise=10 ** (config.fans_db / 20),
    )
    array = MicrophoneArray(positions + np.array([0.0, 0.0, 0.9]), body_m=float(np.linalg.norm(positions[0])))
    results = run(VoicePipeline(array, RATE, PipelineSettings(separation=separation)), as_int16(sound.T))
    begins, ends = truths[0].times_s[truths[0].active][[0, -1]]
    judged = [
        max((s.speech for s in m.sources if s.active and degrees(s.direction, toward(30, 15)) < 20), default=0.0)
        for m, _ in results
        if begins + 0.75 < m.stamp < ends
    ]
    # What keeps LocateVoices desired: a source that sounds and is at least as probably a voice as not.
    assert np.mean(np.array(judged) >= 0.5) > 0.9


def test_noise_from_everywhere_is_no_source_and_what_it_refuses() -> None:
    pipeline = VoicePipeline(PLACED, RATE)
    noise = as_int16(np.random.default_rng(5).normal(0, 0.01, (RATE, 8)))
    assert not any(message.sources for message, _ in run(pipeline, noise))
    with pytest.raises(ValueError, match="samples are"):
        pipeline.process(noise[:100], 0.0)
    with pytest.raises(ValueError, match="samples are"):
        pipeline.process(noise[: pipeline.step, :4], 0.0)
