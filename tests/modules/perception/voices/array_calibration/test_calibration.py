"""Whole calibrations: of claps as sound to positions, order, gains, faults and a verdict."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.arrival_times import arrivals_of
from app.modules.perception.voices.array_calibration.calibration import calibrate, longest_lag_s, rough_direction
from app.modules.perception.voices.array_calibration.claps import Clap
from app.modules.perception.voices.array_calibration.results import NotEnough, Verdict
from app.modules.perception.voices.array_calibration.structure import aligned
from app.modules.perception.voices.array_calibration.verdict import unseen_of
from app.modules.perception.voices.microphone_array import MicrophoneArray
from tests.modules.perception.voices.array_calibration.clap_sounds import CORNERS, CROSS, around, clap_of, heard_at

GAINS_DB = np.array([0.0, 1.5, -1.0, 0.0, 3.0, 0.0, -2.0, 0.0])
#: Configured in the robot's frame, not about their middle.
CONFIGURED = CORNERS + np.array([0.1, 0.0, 0.4])
TRUE = CONFIGURED + np.random.default_rng(7).normal(0, 0.006, CORNERS.shape)


def claps(count: int = 14) -> list[Clap]:
    """Claps around TRUE."""
    middle = TRUE.mean(axis=0)
    sounds = [heard_at(middle + source, TRUE, number) for number, source in enumerate(around(count, 7))]
    return [clap_of(sound * 10 ** (GAINS_DB / 20)) for sound in sounds]


CLAPS = claps()


def changed(order: list[int] | None = None, silent: int | None = None) -> list[Clap]:
    """The same with channels in another order, or a silent one."""
    found = []
    for clap in CLAPS:
        sound = clap.sound[:, order or list(range(8))].copy()
        if silent is not None:
            sound[:, silent] = 0
        found.append(Clap(clap.at_s, sound, clap.rate, clap.onset, clap.clipped))
    return found


def error_m(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    return float(np.sqrt(((aligned(found, true) - true) ** 2).sum(axis=1).mean()))


def test_positions_and_gains_are_found_and_to_be_adopted() -> None:
    result = calibrate(CLAPS, MicrophoneArray(CONFIGURED))
    assert result.verdict is Verdict.ADOPT
    assert result.order is None
    assert error_m(CONFIGURED, TRUE) > 0.007
    assert error_m(result.positions, TRUE) < 0.001
    np.testing.assert_allclose(result.positions.mean(axis=0), CONFIGURED.mean(axis=0), atol=1e-9)
    assert result.held_out_after_s < 3e-6 < 8e-6 < result.held_out_before_s
    gains = np.array([one.gain_db for one in result.microphones])
    np.testing.assert_allclose(gains, GAINS_DB - np.median(GAINS_DB), atol=0.4)
    moved = [one.moved_m for one in result.microphones]
    np.testing.assert_allclose(moved, np.linalg.norm(result.positions - CONFIGURED, axis=1))
    assert max(one.residual_s for one in result.microphones) < 2e-6
    assert all(clap.used for clap in result.claps)
    azimuths = np.array([clap.azimuth_deg for clap in result.claps])
    true = np.degrees(np.arctan2(*around(14, 7).T[1::-1]))
    assert np.abs((azimuths - true + 180) % 360 - 180).max() < 4


def test_right_positions_are_kept() -> None:
    result = calibrate(CLAPS, MicrophoneArray(TRUE))
    assert result.verdict is Verdict.KEEP
    assert "explain the claps as well" in result.reasons[0]
    assert result.held_out_before_s < 2e-6


def test_a_wrong_order_is_found_and_proposed() -> None:
    order = [0, 1, 6, 3, 4, 5, 2, 7]
    result = calibrate(changed(order), MicrophoneArray(CONFIGURED))
    assert result.order == tuple(order)
    assert result.verdict is Verdict.ADOPT
    assert result.reasons[0] == "the channels are in another order than configured"
    assert error_m(result.positions, TRUE[order]) < 0.001


def test_a_silent_microphone_is_named_and_stays_where_it_was() -> None:
    result = calibrate(changed(silent=3), MicrophoneArray(CONFIGURED))
    assert result.microphones[3].fault == "hears none of the claps"
    assert np.isnan([result.microphones[3].gain_db, result.microphones[3].residual_s]).all()
    np.testing.assert_allclose(result.positions[3], CONFIGURED[3])
    others = [channel for channel in range(8) if channel != 3]
    assert error_m(result.positions[others], TRUE[others]) < 0.001
    assert result.verdict is Verdict.ADOPT


def test_a_flat_array() -> None:
    true = CROSS + np.random.default_rng(3).normal(0, 0.002, CROSS.shape) * (1, 1, 0)
    level = [clap_of(heard_at(source, true, number)) for number, source in enumerate(around(14, 8, level=True))]
    result = calibrate(level, MicrophoneArray(CROSS))
    assert result.verdict is Verdict.ADOPT
    assert error_m(result.positions, true) < 0.4 * error_m(CROSS, true)
    assert any("across the plane" in sentence for sentence in result.unseen)
    uneven = [clap_of(heard_at(source, true, number)) for number, source in enumerate(around(14, 8))]
    result = calibrate(uneven, MicrophoneArray(CROSS))
    assert result.verdict is Verdict.REPEAT
    assert any("different heights" in reason for reason in result.reasons)


@pytest.mark.parametrize(("factor", "verdict"), [(0.6, Verdict.ADOPT), (1.5, Verdict.REPEAT)])
def test_the_size_of_a_flat_array(factor: float, verdict: Verdict) -> None:
    level = [clap_of(heard_at(source, CROSS, number)) for number, source in enumerate(around(14, 8, level=True))]
    result = calibrate(level, MicrophoneArray(factor * CROSS))
    assert result.verdict is verdict
    if verdict is Verdict.ADOPT:
        assert error_m(result.positions, CROSS) < 0.001 < 0.01 < error_m(factor * CROSS, CROSS)
    else:
        assert "its microphones are 0.6" in result.reasons[-1]


def test_claps_from_one_side_are_not_enough() -> None:
    sources = np.array([1.5, 0.2, 0.3]) + 0.06 * around(12, 9)
    result = calibrate(
        [clap_of(heard_at(source, CORNERS, number)) for number, source in enumerate(sources)], MicrophoneArray(CORNERS)
    )
    assert result.verdict is Verdict.REPEAT
    assert any("clap from more directions" in reason for reason in result.reasons)


def test_too_little_is_said() -> None:
    with pytest.raises(NotEnough, match=r"5 of 5 claps are clear .* at least 8 are needed"):
        calibrate(CLAPS[:5], MicrophoneArray(CONFIGURED))
    with pytest.raises(NotEnough, match="the array has 2 microphones on a line"):
        calibrate([], MicrophoneArray(CONFIGURED[:2]))
    noise = np.random.default_rng(0)
    hiss = [
        Clap(0.0, noise.normal(0, 0.1, one.sound.shape).astype(np.float32), one.rate, one.onset, False) for one in CLAPS
    ]
    with pytest.raises(NotEnough):
        calibrate(hiss, MicrophoneArray(CONFIGURED))


def test_directions_are_known_roughly_at_once() -> None:
    sources = around(14, 7)
    for clap, source in zip(CLAPS[:4], sources, strict=False):
        arrivals = arrivals_of(clap, longest_lag_s(MicrophoneArray(CONFIGURED)))
        found = rough_direction(arrivals, MicrophoneArray(CONFIGURED))
        assert float(found @ source / np.linalg.norm(source)) > np.cos(np.radians(12))
    flat = MicrophoneArray(CROSS)
    arrivals = arrivals_of(clap_of(heard_at(np.array([1.0, 0.0, -0.6]), CROSS, 1)), longest_lag_s(flat))
    # Below and above the plane are alike.
    np.testing.assert_allclose(rough_direction(arrivals, flat), np.array([1.0, 0.0, 0.6]) / np.hypot(1, 0.6), atol=0.05)


@pytest.mark.parametrize(("dimensions", "count"), [(1, 2), (2, 2), (3, 1)])
def test_what_sound_does_not_show_is_said(dimensions: int, count: int) -> None:
    assert len(unseen_of(dimensions)) == count
