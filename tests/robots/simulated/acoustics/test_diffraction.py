"""The sphere against published values and its limits; the tables against the exact series; delays and spreading."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.robots.simulated.acoustics.diffraction import (
    SPEED_OF_SOUND_MPS,
    TAPS,
    BaffledMicrophones,
    sphere_response,
)

RATE = 48000
HEAD_M = 0.0875


def db(response: NDArray[np.complex128]) -> NDArray[np.float64]:
    return np.asarray(20 * np.log10(np.abs(response)))


def frequency_of(mu: float, radius_m: float = HEAD_M) -> float:
    """Duda and Martens' normalized frequency mu = ka in Hz."""
    return mu * SPEED_OF_SOUND_MPS / (2 * math.pi * radius_m)


@pytest.mark.parametrize("rho", [1.25, 2.0, 4.0, 100.0])
def test_near_sources_at_long_waves_reach_the_series_closed_form(rho: float) -> None:
    """At ka -> 0 Duda and Martens' series is sum (2m+1)/(m+1) (a/rho)^m P_m, which has a sum in front and behind."""
    x = 1 / rho
    front, behind = 2 / (1 - x) + math.log(1 - x) / x, 2 / (1 + x) - math.log(1 + x) / x
    response = np.abs(sphere_response(HEAD_M, [1.0, -1.0], 1.0, rho * HEAD_M))[:, 0]
    np.testing.assert_allclose(response, [front, behind], rtol=2e-3)


def test_the_short_wave_limits_are_a_mirror_in_front_and_a_bright_spot_behind() -> None:
    """Duda and Martens, figure 2: 6 dB in front, the deepest shade near 170 degrees, far less of it at 180."""
    degrees = [0.0, 120.0, 150.0, 170.0, 180.0]
    levels = db(sphere_response(HEAD_M, np.cos(np.radians(degrees)), frequency_of(30.0)))[:, 0]
    assert levels[0] == pytest.approx(6.0, abs=0.2)
    assert np.all(np.diff(levels[:4]) < 0)
    assert levels[2] < -10.0
    assert levels[4] > levels[3] + 10.0


def test_long_waves_do_not_see_the_sphere_but_are_delayed_by_one_and_a_half_of_the_way() -> None:
    """Kuhn 1977: at low frequencies the phase is that of 3/2 a cos(angle)."""
    f = frequency_of(0.05)
    response = sphere_response(HEAD_M, [1.0, 0.5, -1.0], f)[:, 0]
    np.testing.assert_allclose(np.abs(response), 1.0, atol=0.01)
    expected = 2 * math.pi * f / SPEED_OF_SOUND_MPS * 1.5 * HEAD_M * np.array([1.0, 0.5, -1.0])
    np.testing.assert_allclose(np.angle(response), expected, atol=0.003)


def test_a_source_within_the_sphere_is_refused() -> None:
    with pytest.raises(ValueError, match="inside the sphere"):
        sphere_response(0.1, 1.0, 1000.0, 0.09)


@pytest.mark.parametrize("seed", range(8))
def test_tables_are_true_to_the_exact_series(seed: int) -> None:
    rng = np.random.default_rng(seed)
    d, azimuth, up = rng.uniform(1.0, 10.0), rng.uniform(-math.pi, math.pi), rng.uniform(-1.0, 1.2)
    corner = np.array([0.085, 0.11, 0.105])
    array = BaffledMicrophones(np.array([corner * s for s in ((1, 1, 1), (1, -1, -1), (-1, 1, 1))]), RATE)
    direction = np.array([math.cos(up) * math.cos(azimuth), math.cos(up) * math.sin(azimuth), math.sin(up)])
    impulses = array.impulses(d * direction[None], np.ones((1, 1)), 2048)[0]
    f = np.fft.rfftfreq(2048, 1 / RATE)
    band = (f > 300) & (f < 16000)
    radius = float(np.linalg.norm(corner))
    cosines = array.p_AM @ direction / radius
    exact = sphere_response(radius, cosines, f[band], d) * np.exp(-2j * math.pi * f[band] * d / SPEED_OF_SOUND_MPS) / d
    ours = np.fft.rfft(impulses, axis=1)[:, band]
    level_error = np.sqrt(np.mean((20 * np.log10(np.abs(ours) / np.abs(exact))) ** 2, axis=1))
    whole_error = np.abs(ours - exact).max(1) / np.abs(exact).max(1)
    lit = cosines > 0
    assert np.all(level_error < np.where(lit, 0.1, 2.0))
    assert np.all(whole_error < np.where(lit, 0.06, 0.2))


def arrival(impulse: NDArray[np.float32]) -> float:
    """The moment (in samples) of a response's arrival, by the phase of its spectrum."""
    spectrum = np.fft.rfft(impulse, 8192)
    f = np.arange(spectrum.size) / 8192
    band = (f > 0.02) & (f < 0.3)
    return float(-np.polyfit(2 * math.pi * f[band], np.unwrap(np.angle(spectrum))[band], 1)[0])


@settings(max_examples=25, deadline=None)
@given(st.tuples(*[st.floats(-4, 4)] * 3).filter(lambda p: math.hypot(*p) > 0.5))
def test_in_the_free_field_delays_are_those_of_the_way_to_a_twentieth_of_a_sample(place: tuple[float, ...]) -> None:
    p_AM = np.array([[0.1, 0.2, 0.1], [-0.1, 0.05, 0.3]])
    impulses = BaffledMicrophones(p_AM, RATE, shadow=False).impulses(np.array([place]), np.ones((1, 1)), 2048)[0]
    ways = np.linalg.norm(np.array(place) - p_AM, axis=1)
    for impulse, way in zip(impulses, ways, strict=True):
        assert arrival(impulse) == pytest.approx(way / SPEED_OF_SOUND_MPS * RATE, abs=0.05)


def test_in_the_light_delays_between_microphones_are_those_of_the_ways(shaded: BaffledMicrophones) -> None:
    place = np.array([2.0, 0.1, 0.2])
    impulses = shaded.impulses(place[None], np.ones((1, 1)), 1024)[0]
    front = np.flatnonzero(shaded.p_AM[:, 0] > 0)
    ways = np.linalg.norm(place - shaded.p_AM[front], axis=1) / SPEED_OF_SOUND_MPS * RATE
    measured = np.array([arrival(impulses[m]) for m in front])
    np.testing.assert_allclose(measured - measured[0], ways - ways[0], atol=0.05)


@pytest.mark.parametrize("shadow", [False, True])
def test_twice_as_far_is_six_decibels_less(positions: NDArray[np.float64], shadow: bool) -> None:
    array = BaffledMicrophones(positions, RATE, shadow)
    energies = [
        float(np.sum(array.impulses(np.array([[d, 0.0, 0.0]]), np.ones((1, 1)), 4096)[0, :, :] ** 2))
        for d in (4.0, 8.0)
    ]
    assert 10 * math.log10(energies[0] / energies[1]) == pytest.approx(6.02, abs=0.1)


def test_the_torso_shades_what_is_behind_it(shaded: BaffledMicrophones, free: BaffledMicrophones) -> None:
    place = np.array([[3.0, 0.0, 0.0]])
    with_torso, without = (np.sum(a.impulses(place, np.ones((1, 1)), 1024)[0] ** 2, axis=1) for a in (shaded, free))
    gain_db = 10 * np.log10(with_torso / without)
    front = shaded.p_AM[:, 0] > 0
    assert np.all(gain_db[front] > 2.0)
    assert np.all(gain_db[~front] < -2.0)


def test_what_falls_outside_the_response_is_cut_off(free: BaffledMicrophones) -> None:
    places = np.array([[1.0, 0.0, 0.0], [500.0, 0.0, 0.0]])
    impulses = free.impulses(places, np.ones((2, 1)), 512)
    assert impulses.shape == (1, 8, 512)
    np.testing.assert_array_equal(impulses, free.impulses(places[:1], np.ones((1, 1)), 512))
    assert not free.impulses(np.zeros((0, 3)), np.zeros((0, 2)), 64).any()


def test_the_loudspeaker_on_the_torso_reaches_every_microphone(shaded: BaffledMicrophones) -> None:
    impulses = shaded.impulses(np.array([[0.1, 0.0, 0.005]]), np.ones((1, 1)), 256)[0]
    assert np.isfinite(impulses).all()
    assert np.all(np.abs(impulses).max(1) > 1.0)
    assert impulses.shape[1] > TAPS
