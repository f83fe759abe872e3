"""The response to sound of one direction: greatest there, found from near by, and aligned at all microphones."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steered_response import SteeredResponse, lag_transform
from app.modules.perception.voices.steering_vectors import arrivals
from app.robots.stream_config import MicrophonesConfig

RATE = 48_000
ARRAY = MicrophoneArray(np.array(MicrophonesConfig().positions))
FREQUENCIES = np.asarray(np.fft.rfftfreq(1024, 1 / RATE)[5:150], np.float64)
RANGE_M = 1.8


@pytest.fixture(scope="module")
def response() -> SteeredResponse:
    return SteeredResponse(ARRAY, RATE, FREQUENCIES, points=1200, lowest_deg=-20.0, range_m=RANGE_M)


def unit(azimuth_deg: float, elevation_deg: float) -> NDArray[np.float64]:
    a, e = np.radians([azimuth_deg, elevation_deg])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def phases(direction: NDArray[np.float64]) -> NDArray[np.complex64]:
    """Of sound from there, at each microphone and frequency: (M, B)."""
    delays = arrivals(ARRAY.offsets, direction[None], RANGE_M)[0]
    return np.exp(-2j * np.pi * delays[:, None] * FREQUENCIES).astype(np.complex64)


def cross_spectra(direction: NDArray[np.float64]) -> NDArray[np.complex64]:
    of_each = phases(direction)
    return np.asarray(of_each[ARRAY.first] * of_each[ARRAY.second].conj())


def degrees(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def test_phases_of_one_delay_agree_at_its_lag_alone() -> None:
    lags = np.arange(-20, 21) / RATE
    cross = np.exp(-2j * np.pi * FREQUENCIES * lags[26])
    correlation = np.hstack([cross.real, cross.imag]) @ lag_transform(FREQUENCIES, lags)
    assert correlation.argmax() == 26
    assert correlation[26] == pytest.approx(1.0, abs=1e-5)
    assert np.delete(correlation, range(21, 32)).max() < 0.3


@pytest.mark.parametrize("direction", [unit(0, 0), unit(40, 20), unit(-170, 70)])
def test_the_response_is_greatest_where_sound_comes_from(
    response: SteeredResponse, direction: NDArray[np.float64]
) -> None:
    correlation = response.correlation(cross_spectra(direction))
    on_grid = response.on_grid(correlation)
    best = response.grid[int(on_grid.argmax())]
    assert on_grid.shape == (len(response.grid),)
    assert degrees(best, direction) < 5
    maxima, powers = response.climb(correlation, np.stack([best, unit(-60, 0)]), 2)
    assert degrees(maxima[0], direction) < 0.3
    assert 0.9 < powers[0] <= 1
    assert powers[1] < 0.5
    np.testing.assert_allclose(np.linalg.norm(maxima, axis=1), 1)


def test_without_a_round_the_response_is_read_where_it_is(response: SteeredResponse) -> None:
    direction = unit(10, 30)
    correlation = response.correlation(cross_spectra(direction))
    same, power = response.climb(correlation, direction[None], 0)
    np.testing.assert_array_equal(same[0], direction)
    _, aside = response.climb(correlation, unit(20, 30)[None], 0)
    assert power[0] > 0.9 > aside[0]


def test_steered_phases_of_sound_from_there_are_one_and_the_same(response: SteeredResponse) -> None:
    direction = unit(-35, 15)
    aligned = phases(direction) * response.steering(direction[None])[0]
    np.testing.assert_allclose(aligned, 1, atol=1e-3)
