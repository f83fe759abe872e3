from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, lfilter_zi

from app.modules.perception.loud_noises import FRAME, BandEnergy, LoudnessRule, OnsetDetector, decibels

RATE = 48_000
FAN = 10**-5.0


def hum(frames: int, level: float = FAN, seed: int = 0) -> NDArray[np.float64]:
    """Energies of a steady noise, as unsteady as a band of noise in 10 ms is."""
    return level * np.random.default_rng(seed).chisquare(100, frames) / 100


def clap(peak: float) -> NDArray[np.float64]:
    """A clap and its echo in a room of 0.5 s reverberation."""
    return peak * 10 ** (-6.0 * np.arange(48) / 47)


def begins(energies: NDArray[np.float64], rule: LoudnessRule | None = None) -> list[int]:
    detector = OnsetDetector(rule)
    return [number for number, energy in enumerate(energies.tolist()) if detector.update(energy) is not None]


def with_clap(energies: NDArray[np.float64], at: int, peak: float) -> NDArray[np.float64]:
    energies = energies.copy()
    echo = clap(peak)
    energies[at : at + len(echo)] += echo
    return energies


# --- The detector
# -------------------------------------------------------------------------------------------------------


def test_a_clap_is_one_noise_at_the_frame_it_begins_with_its_ratio() -> None:
    detector = OnsetDetector()
    found = {n: r for n, e in enumerate(with_clap(hum(600), 400, 1e-2)) if (r := detector.update(float(e))) is not None}
    assert list(found) == [400]
    assert found[400] == pytest.approx(1e-2 / FAN, rel=0.05)


def test_claps_that_follow_each_other_are_each_reported_and_louder_or_softer_ones_too() -> None:
    energies = hum(1500)
    at = [400, 480, 560, 700, 1200]
    for place, peak in zip(at, (1e-2, 8e-3, 1e-2, 3e-3, 6e-2), strict=True):
        energies = with_clap(energies, place, peak)
    assert begins(energies) == at


@given(st.lists(st.floats(1e-10, 1.0), min_size=1, max_size=100), st.floats(2, 1000))
def test_it_never_reports_anything_at_the_start(energies: list[float], ratio: float) -> None:
    assert begins(np.array(energies), LoudnessRule(ratio=ratio)) == []


@settings(max_examples=20)
@given(st.integers(-6, 10), st.integers(0, 2**32 - 1))
def test_scaling_the_whole_sound_changes_nothing_above_the_floor(octaves: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Whatever else, the background stays above the floor's: -60 dB and more for all gains.
    energies = hum(700, 1e-4, seed=seed)
    for place in rng.integers(120, 640, 4):
        energies = with_clap(energies, int(place), 10 ** rng.uniform(-3.5, 0))
    rule = LoudnessRule(floor_db=-75)
    detector, scaled = OnsetDetector(rule), OnsetDetector(rule)
    gain = 4.0**octaves
    assert [detector.update(e) for e in energies.tolist()] == [scaled.update(gain * e) for e in energies.tolist()]


@pytest.mark.parametrize("db_per_minute", [-20, -5, 5, 20])
def test_a_level_that_drifts_is_followed(db_per_minute: float) -> None:
    frames = round(60 * RATE / FRAME)
    level = 10 ** (db_per_minute * np.arange(frames) / frames / 10)
    energies = hum(frames) * level * (100 if db_per_minute < 0 else 1)
    assert begins(energies) == []
    (at,) = begins(with_clap(energies, frames - 200, 200 * float(energies[frames - 200])), LoudnessRule(floor_db=-60))
    assert at == frames - 200


@pytest.mark.parametrize("step_db", [20, 40])
def test_a_level_that_jumps_is_reported_once_and_then_usual(step_db: float) -> None:
    """A vacuum cleaner is switched on: after a few seconds, claps beside it are detected again."""
    energies = hum(1500)
    energies[400:] *= 10 ** (step_db / 10)
    energies = with_clap(energies, 1300, 60 * float(energies[1300]))
    assert begins(energies, LoudnessRule(floor_db=-45)) == [400, 1300]


def test_a_whisper_after_digital_silence_is_none_and_a_clap_is() -> None:
    silence = np.zeros(900)
    whisper = silence.copy()
    whisper[300:400] = 10**-4.5
    assert begins(whisper) == []
    assert begins(with_clap(whisper, 700, 1e-2)) == [700]


def test_one_clap_leaves_the_background_where_it_was() -> None:
    detector = OnsetDetector()
    for energy in hum(400).tolist():
        detector.update(energy)
    before = detector.background
    for energy in clap(0.1).tolist():
        detector.update(energy)
    assert detector.background < 3.0 * before
    plain_mean = (400 * before + clap(0.1).sum()) / 448
    assert plain_mean > 20 * before, "the thesis's own mean would be deaf now"


def test_people_who_talk_are_no_news_but_one_who_calls_is() -> None:
    """Syllables 15 dB over their own mean of the last seconds again and again; then a call 10 dB above them."""
    rng = np.random.default_rng(5)
    energies = hum(4000, 1e-6)
    for begin in range(500, 3900, 250):
        for syllable in range(begin, begin + 180, 15):
            energies[syllable : syllable + 8] += 10 ** (-3.6 + rng.uniform(-0.2, 0.2))
    found = begins(energies, LoudnessRule(floor_db=-60))
    assert found
    assert max(found) < 2000, "once ten seconds of it were heard, it is usual"
    assert max(begins(with_clap(energies, 3700, 10**-2.3), LoudnessRule(floor_db=-60))) == 3700


def test_what_grows_out_of_talk_is_none_and_what_bursts_out_of_quiet_is() -> None:
    grown, burst = hum(600), hum(600)
    # Syllables that grow, a sixth of a second long in all; the last are above the floor and the ratio.
    grown[385:400] = np.geomspace(1e-4, 6e-4, 15)
    grown[400:406] = 1.2e-3
    burst[400:406] = 1.2e-3
    assert begins(grown) == []
    assert begins(burst) == [400]
    # Louder than any speech, it may rise as it likes.
    grown[400:406] = 1e-2
    assert begins(grown) == [400]


def test_a_long_noise_is_one() -> None:
    energies = hum(1000)
    energies[300:420] += 1e-2 * (1.2 + np.sin(np.arange(120)))
    assert begins(energies) == [300]


@settings(max_examples=20)
@given(st.lists(st.floats(1e-9, 0.1), min_size=300, max_size=500))
def test_the_background_never_leaves_what_was_heard(energies: list[float]) -> None:
    detector = OnsetDetector()
    for energy in energies:
        detector.update(energy)
        assert 0 < detector.background <= max(energies) * (1 + 1e-9)


def test_the_rule_changes_in_the_midst() -> None:
    detector = OnsetDetector()
    energies = with_clap(hum(600), 500, 1e-2).tolist()
    for energy in energies[:450]:
        detector.update(energy)
    detector.follow(LoudnessRule(ratio=1e5))
    assert all(detector.update(energy) is None for energy in energies[450:])
    detector.follow(LoudnessRule(window=50, history=20))
    assert detector.background == 0, "another window begins afresh"
    assert [n for n, e in enumerate(with_clap(hum(120), 60, 1e-2).tolist()) if detector.update(e) is not None] == [60]


def test_a_thud_is_none_however_loud() -> None:
    detector = OnsetDetector()
    for energy in hum(400).tolist():
        assert detector.update(energy, lambda: 0.0) is None
    assert detector.update(1e-2, lambda: 0.2) is None
    assert detector.update(1e-2, lambda: 0.02) is not None


# --- The band --------------------------------------------------------------------------------------------------------


def frames(samples: NDArray[np.int16], band: BandEnergy | None = None) -> NDArray[np.float64]:
    band = band or BandEnergy(RATE)
    return np.array([band.frame(frame) for frame in samples.reshape(-1, FRAME)])


def tone(hz: float, seconds: float = 0.5, rate: int = RATE) -> NDArray[np.int16]:
    count = round(seconds * rate) // FRAME * FRAME
    return (16384 * np.sin(2 * np.pi * hz * np.arange(count) / rate)).astype(np.int16)


@pytest.mark.parametrize("rate", [8_000, 16_000, 22_050, 32_000, 44_100, 48_000, 96_000])
def test_a_tone_in_the_band_has_its_mean_square_whatever_the_rate(rate: int) -> None:
    energies = frames(tone(1500, rate=rate), BandEnergy(rate))
    np.testing.assert_allclose(energies[5:], 0.125, rtol=0.15)


@pytest.mark.parametrize(("hz", "most_db"), [(20, -43), (50, -30), (100, -18)])
def test_hum_and_thuds_are_left_out(hz: float, most_db: float) -> None:
    energies = frames(tone(hz))
    assert decibels(float(energies[5:].max()) / 0.125) < most_db


@given(st.integers(0, 2**32 - 1), st.sampled_from((8_000, 44_100, 48_000)))
def test_frame_by_frame_is_the_filter_over_the_whole(seed: int, rate: int) -> None:
    samples = np.random.default_rng(seed).normal(300, 1000, FRAME * 14).astype(np.int16)
    step = {8_000: 1, 44_100: 4, 48_000: 4}[rate]
    thinned = samples.reshape(-1, step).mean(axis=1, dtype=np.float64)
    b, a = butter(2, 300, "highpass", fs=rate / step)
    passed, _ = lfilter(b, a, thinned, zi=lfilter_zi(b, a) * thinned[0])
    expected = (passed.reshape(14, -1) ** 2).mean(axis=1) / 32768**2
    np.testing.assert_allclose(frames(samples, BandEnergy(rate)), expected, rtol=1e-3)


def test_an_offset_of_the_microphone_is_no_noise() -> None:
    assert frames(np.full(FRAME * 4, 9000, np.int16)).max() < 1e-9


def test_decibels() -> None:
    assert decibels(1.0) == 0
    assert decibels(0.0) == pytest.approx(-120)
    assert decibels(0.5) == pytest.approx(10 * math.log10(0.5))
