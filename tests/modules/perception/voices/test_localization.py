"""Directions of sounds made in free air, of one and of two, and what the localizer must not hear."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.localization import Localizer, LocalizerSettings, Peaks
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND, arrivals
from app.robots.stream_config import MicrophonesConfig

RATE = 48_000
ARRAY = MicrophoneArray(np.array(MicrophonesConfig().positions))


def unit(azimuth_deg: float, elevation_deg: float) -> NDArray[np.float64]:
    a, e = np.radians([azimuth_deg, elevation_deg])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def plane_waves(
    direction: NDArray[np.float64], seconds: float, rng: np.random.Generator, array: MicrophoneArray = ARRAY
) -> NDArray[np.float64]:
    """White noise from far away in bursts, as speech comes: (N, M)."""
    count = int(seconds * RATE)
    noise = rng.normal(0, 0.1, count) * (np.sin(np.arange(count) / RATE * 2 * np.pi * 4 + rng.uniform(0, 6)) > -0.3)
    turns = np.fft.rfftfreq(count, 1 / RATE)[:, None] * (-array.offsets @ direction / SPEED_OF_SOUND)
    return np.asarray(np.fft.irfft(np.fft.rfft(noise)[:, None] * np.exp(-2j * np.pi * turns), count, axis=0))


def hear(localizer: Localizer, sound: NDArray[np.float64]) -> Peaks:
    rng = np.random.default_rng(0)
    heard = (sound + rng.normal(0, 1e-3, sound.shape)).astype(np.float32)
    ends = range(localizer.step, len(heard) + 1, localizer.step)
    return [localizer.process(heard[end - localizer.step : end]) for end in ends][-1]


def degrees(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.fixture(scope="module")
def far() -> Localizer:
    return Localizer(ARRAY, RATE, LocalizerSettings(range_m=np.inf))


@pytest.mark.parametrize("seed", range(6))
def test_a_far_sound_is_found_within_a_degree(far: Localizer, seed: int) -> None:
    rng = np.random.default_rng(seed)
    direction = unit(rng.uniform(-180, 180), rng.uniform(-10, 60))
    far.reset()
    peaks = hear(far, plane_waves(direction, 0.6, rng))
    assert degrees(peaks.directions[0], direction) < 1
    assert peaks.powers[0] > 0.3
    assert peaks.echoes[0] == 0
    assert degrees(peaks.steady[0], direction) < 1


@pytest.mark.parametrize("seed", range(3))
def test_two_at_once_are_both_found(far: Localizer, seed: int) -> None:
    rng = np.random.default_rng(seed)
    first = rng.uniform(-180, 180)
    directions = [unit(first, 10), unit(first + rng.uniform(50, 180), 25)]
    far.reset()
    peaks = hear(far, plane_waves(directions[0], 0.8, rng) + 0.7 * plane_waves(directions[1], 0.8, rng))
    for direction in directions:
        assert min(degrees(found, direction) for found in peaks.steady[:2]) < 2


def test_a_sound_at_a_talkers_distance_is_a_sphere() -> None:
    localizer = Localizer(ARRAY, RATE)
    direction = unit(40, 20)
    delays = arrivals(ARRAY.offsets, direction[None], 1.8)[0]
    noise = np.random.default_rng(1).normal(0, 0.1, int(0.5 * RATE))
    spectrum = np.fft.rfft(noise)[:, None] * np.exp(
        -2j * np.pi * np.fft.rfftfreq(len(noise), 1 / RATE)[:, None] * delays
    )
    peaks = hear(localizer, np.fft.irfft(spectrum, len(noise), axis=0))
    assert degrees(peaks.directions[0], direction) < 0.5


def test_silence_and_what_every_microphone_hears_for_itself_are_nowhere(far: Localizer) -> None:
    far.reset()
    silent = far.process(np.zeros((far.step, 8), np.float32))
    assert silent.directions.shape == (0, 3)
    far.reset()
    noise = np.random.default_rng(3).normal(0, 0.1, (RATE * 2, 8))
    assert max(hear(far, noise).powers, default=0) < 0.05


def test_the_past_is_forgotten_on_demand(far: Localizer) -> None:
    rng = np.random.default_rng(5)
    far.reset()
    hear(far, plane_waves(unit(100, 0), 0.6, rng))
    far.reset()
    direction = unit(-60, 20)
    assert degrees(hear(far, plane_waves(direction, 0.6, rng)).directions[0], direction) < 1


def test_what_is_expected_is_followed_before_it_is_searched(far: Localizer) -> None:
    rng = np.random.default_rng(6)
    far.reset()
    direction = unit(20, 20)
    sound = plane_waves(direction, 0.5, rng)[: far.step].astype(np.float32)
    assert len(far.process(sound).powers) == 0
    far.reset()
    peaks = far.process(sound, expected=unit(24, 18)[None])
    assert degrees(peaks.directions[0], direction) < 2
    assert np.isnan(peaks.steady).all()


def test_spectra_of_the_last_step_are_there_for_a_separator() -> None:
    localizer = Localizer(ARRAY, RATE)
    sound = np.random.default_rng(7).normal(0, 0.1, (localizer.step, 8)).astype(np.float32)
    localizer.process(sound)
    assert localizer.spectra.shape == (localizer.settings.frames, 8, 513)
    last = sound[-1024:].T * localizer.window
    np.testing.assert_allclose(localizer.spectra[-1], np.fft.rfft(last), atol=1e-3)
    squares = localizer.window**2
    np.testing.assert_allclose(squares[:512] + squares[512:], 1, atol=1e-6)


def test_samples_of_another_shape_are_refused(far: Localizer) -> None:
    with pytest.raises(ValueError, match=r"samples are \(\d+, 8\), not \(512, 8\)"):
        far.process(np.zeros((512, 8), np.float32))


def test_two_microphones_report_the_angle_to_their_line() -> None:
    pair = ARRAY.subset(2)
    localizer = Localizer(pair, RATE, LocalizerSettings(range_m=np.inf))
    rng = np.random.default_rng(8)
    for azimuth in (-50, 10, 70):
        localizer.reset()
        peaks = hear(localizer, plane_waves(unit(azimuth, 0), 0.6, rng, pair))
        assert degrees(peaks.directions[0], unit(azimuth, 0)) < 2
        localizer.reset()  # from behind it comes as from the mirror in front
        peaks = hear(localizer, plane_waves(unit(180 - azimuth, 0), 0.6, rng, pair))
        assert degrees(peaks.directions[0], unit(azimuth, 0)) < 2


def test_the_robots_own_steady_sound_is_learnt_and_no_longer_heard() -> None:
    far = Localizer(ARRAY, RATE, LocalizerSettings(range_m=np.inf))
    rng = np.random.default_rng(9)
    count = 5 * RATE
    turns = np.fft.rfftfreq(count, 1 / RATE)[:, None] * (-ARRAY.offsets @ unit(0, 80) / SPEED_OF_SOUND)
    fan = np.fft.irfft(np.fft.rfft(rng.normal(0, 3e-3, count))[:, None] * np.exp(-2j * np.pi * turns), count, axis=0)
    # Partly each microphone's own: the air turns about every one of them.
    fan += rng.normal(0, 2.5e-3, fan.shape)
    early = hear(far, fan[: RATE // 2])
    assert degrees(early.directions[0], unit(0, 80)) < 2
    assert max(hear(far, fan[RATE // 2 :]).powers, default=0) < 0.03
    voice = unit(70, 15)
    peaks = hear(far, fan[: RATE // 2] + plane_waves(voice, 0.5, rng))
    assert degrees(peaks.directions[0], voice) < 1
    assert not any(degrees(direction, unit(0, 80)) < 20 for direction in peaks.directions)
