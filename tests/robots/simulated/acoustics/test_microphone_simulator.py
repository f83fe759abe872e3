"""Scenes in, frames out: numbers and stamps without a gap, gaps where it must, the robot's own noise, its own voice."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import Audio
from app.robots.simulated.acoustics.ipc import (
    AcousticsSetup,
    ActiveSound,
    LoudspeakerFrame,
    MicrophoneFrame,
    SoundScene,
)
from app.robots.simulated.acoustics.microphone_simulator import LATE_S, MicrophoneSimulator
from app.robots.stream_config import LoudspeakerConfig, MicrophonesConfig
from tests.robots.conftest import make_hall

X_BM = Pose3.from_translation_rpy((0.0, 0.0, 0.6))
WHEELS = ((0.0, 0.22, 0.1), (0.0, -0.22, 0.1))
STAMP = 1.7e9


def make_ear(fans_db: float = -120.0, noise_db: float = -120.0) -> MicrophoneSimulator:
    config = MicrophonesConfig(fans_db=fans_db, noise_db=noise_db)
    sine = (0.1 * np.sin(2 * np.pi * 500 * np.arange(96000) / 48000)).astype(np.float32)
    world = make_hall(rooms=[{"name": "hall", "from": (0, 0), "to": (20, 20), "rt60_s": 0.3}])
    setup = AcousticsSetup(config, LoudspeakerConfig(), world, X_BM, X_BM, WHEELS, {("sine", 0): (sine, 0.07)}, seed=1)
    return MicrophoneSimulator(pickle.loads(pickle.dumps(setup)))


def scene(time_s: float, x: float = 10.0, rims: float = 0.0, sounds: tuple[ActiveSound, ...] = ()) -> SoundScene:
    return SoundScene(time_s, STAMP + time_s, Pose2(x, 10.0, 0.0), (rims, rims), sounds)


def sine_at(time_s: float) -> ActiveSound:
    return ActiveSound("s", ("sine", 0), 0.0, 0.0, True, (12.0 + 0.5 * time_s, 10.0, 1.5), np.pi)


def feed(ear: MicrophoneSimulator, scenes: list[SoundScene]) -> list[MicrophoneFrame]:
    """One after the other, as they come."""
    return [heard for scene_ in scenes for heard in ear.listen([scene_])]


def level_db(frames: list[MicrophoneFrame]) -> float:
    samples = np.concatenate([frame.audio.samples for frame in frames]).astype(float)
    return float(20 * np.log10(samples.std() / 32768 + 1e-12))


def test_frames_come_as_soon_as_the_world_is_past_them_and_follow_one_another() -> None:
    ear = make_ear()
    frames: list[Audio] = []
    for step in range(1, 100):
        time_s = 1.0 + 0.01 * step
        heard = ear.listen([scene(time_s, sounds=(sine_at(time_s),))])
        frames += [frame.audio for frame in heard]
        if frames:
            assert time_s - 0.0107 < (frames[-1].first_sample + 512) / 48000 <= time_s + 1e-9
        assert all(frame.lost == 0 for frame in heard)
    assert len(frames) > 85
    assert np.all(np.diff([frame.first_sample for frame in frames]) == 512)
    for frame in frames:
        assert frame.stamp == pytest.approx(STAMP + frame.first_sample / 48000, abs=2e-6)
    assert frames[0].samples.shape == (512, 8)
    assert frames[0].samples.dtype == np.int16
    np.testing.assert_allclose(frames[0].p_BM[0], [0.085, 0.11, 1.06])
    heard_ = np.concatenate([frame.samples[:, 0] for frame in frames[20:]]).astype(float)
    assert np.abs(np.diff(heard_)).max() < 1.3 * 2 * np.pi * 500 / 48000 * np.abs(heard_).max() + 2


def test_what_is_hopelessly_late_is_left_out_and_counted() -> None:
    ear = make_ear()
    feed(ear, [scene(0.5), scene(0.52)])
    late = [scene(0.53 + 0.01 * n) for n in range(round(LATE_S / 0.01) + 20)]
    heard = ear.listen(late) + ear.listen([scene(late[-1].time_s + 0.011)])
    assert len(heard) <= 2
    assert heard[0].lost > 14
    assert heard[0].audio.first_sample % 512 == 0
    assert (heard[-1].audio.first_sample + 512) / 48000 == pytest.approx(late[-1].time_s + 0.011, abs=0.011)


def test_after_a_pause_it_goes_on_without_counting_a_loss() -> None:
    ear = make_ear()
    feed(ear, [scene(0.5), scene(0.52)])
    heard = feed(ear, [scene(9.0), scene(9.02), scene(9.04)])
    assert heard
    assert all(frame.lost == 0 for frame in heard)
    assert heard[0].audio.first_sample / 48000 >= 9.0


def test_fans_and_microphones_are_as_loud_as_configured() -> None:
    times = [scene(0.5 + 0.01 * n) for n in range(12)]
    assert level_db(feed(make_ear(fans_db=-50.0), times)) == pytest.approx(-50.0, abs=1.5)
    assert level_db(feed(make_ear(noise_db=-60.0), times)) == pytest.approx(-60.0, abs=0.5)


def test_wheels_are_heard_when_they_turn_and_more_the_faster() -> None:
    levels = []
    for rims in (0.0, 0.2, 0.4):
        ear = make_ear()
        levels.append(level_db(feed(ear, [scene(0.5 + 0.01 * n, rims=rims) for n in range(14)])[3:]))
    assert levels[0] < -90
    assert levels[2] == pytest.approx(-52.0, abs=2.0)
    assert levels[2] - levels[1] == pytest.approx(6.0, abs=1.0)


def test_the_robot_hears_its_own_voice_and_louder_than_another_s() -> None:
    ear = make_ear()
    voice = np.rint(20000 * np.sin(2 * np.pi * 700 * np.arange(9600) / 48000)).astype(np.int16)[:, None]
    ear.play(LoudspeakerFrame(Audio(0.0, "operator", voice, 48000, 0, np.zeros((0, 3)))))
    heard = feed(ear, [scene(0.5 + 0.01 * n) for n in range(14)])
    assert level_db(heard[4:]) > -30.0
    spectrum = np.abs(np.fft.rfft(np.concatenate([frame.audio.samples[:, 0] for frame in heard[3:]]), 48000))
    assert np.argmax(spectrum) == pytest.approx(700, abs=5)


def test_louder_than_full_scale_is_clipped_and_counted() -> None:
    ear = make_ear(noise_db=0.0)
    heard = feed(ear, [scene(0.5 + 0.01 * n) for n in range(8)])
    extremes = {int(frame.audio.samples.max()) for frame in heard} | {int(frame.audio.samples.min()) for frame in heard}
    assert extremes == {32767, -32768}
    assert ear.clipped > 100
