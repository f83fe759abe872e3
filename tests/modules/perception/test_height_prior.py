"""How far a ray goes to the face of a person of unknown height."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from app.modules.perception.height_prior import IMPOSSIBLE, SHARES, STANDING, Part, range_from_height

PARTS: list[Part] = ["eyes", "face", "mouth"]


def by_sums(elevation: float, origin: float, part: Part) -> tuple[float, float]:
    """The posterior of the docstring, summed over a fine grid of ranges."""
    ranges = np.linspace(STANDING.nearest_m, STANDING.farthest_m, 200_001)
    z = origin + ranges * math.sin(elevation)
    mean, sigma = STANDING.part(part)
    standing = np.exp(-0.5 * ((z - mean) / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))
    others = ((z >= STANDING.lowest_m) & (z <= STANDING.highest_m)) / (STANDING.highest_m - STANDING.lowest_m)
    p = (1 - STANDING.others) * standing + STANDING.others * others
    evidence = float(p.mean()) * (STANDING.farthest_m - STANDING.nearest_m)
    assume(not 0.5 < evidence / IMPOSSIBLE < 2)
    if evidence < IMPOSSIBLE:
        p = np.ones_like(ranges)
    p /= p.sum()
    m = float((p * ranges).sum())
    return m, math.sqrt(float((p * (ranges - m) ** 2).sum()))


@given(st.floats(-1.5, 1.5), st.floats(0.3, 1.7), st.sampled_from(PARTS))
def test_it_is_the_posterior_summed_numerically(elevation: float, origin: float, part: Part) -> None:
    direction = (math.cos(elevation), 0.0, math.sin(elevation))
    assert range_from_height(direction, origin, part) == pytest.approx(by_sums(elevation, origin, part), abs=2e-3)


@given(st.floats(-math.pi, math.pi), st.floats(0.1, 10), st.floats(-1, 1))
def test_only_the_elevation_matters(azimuth: float, length: float, elevation: float) -> None:
    flat = length * math.cos(elevation)
    direction = (flat * math.cos(azimuth), flat * math.sin(azimuth), length * math.sin(elevation))
    ahead = (math.cos(elevation), 0.0, math.sin(elevation))
    assert range_from_height(direction, 1.1) == pytest.approx(range_from_height(ahead, 1.1), rel=1e-6)


@pytest.mark.parametrize("distance", [1.0, 1.5, 2.0, 3.0])
def test_the_mean_person_is_where_they_stand(distance: float) -> None:
    mean, sigma = STANDING.part("face")
    rise = mean - 0.9
    expected = math.hypot(distance, rise)
    range_m, range_sigma_m = range_from_height((distance, 0.0, rise), 0.9)
    assert range_m == pytest.approx(expected, rel=0.06)
    assert range_sigma_m == pytest.approx(sigma * expected / rise, rel=0.35)


def test_heights_drawn_from_the_gaussian_are_within_the_deviation_as_often_as_it_says() -> None:
    rng = np.random.default_rng(7)
    origin, within = 1.0, []
    for _ in range(2000):
        height, distance = rng.normal(STANDING.mean_m, STANDING.sigma_m), rng.uniform(0.8, 6.0)
        rise = SHARES["mouth"] * height - origin
        range_m, sigma = range_from_height((distance, 0.0, rise), origin, "mouth")
        within.append(abs(range_m - math.hypot(distance, rise)) <= sigma)
    assert 0.6 < np.mean(within) < 0.85


def test_near_the_horizon_it_knows_little_but_something() -> None:
    mean, _ = STANDING.part("face")
    sigmas = [range_from_height((math.cos(e), 0, math.sin(e)), mean - 0.2)[1] for e in (0.4, 0.2, 0.1, 0.05, 0.01)]
    assert sigmas == sorted(sigmas)
    assert sigmas[-1] < 7.5 / math.sqrt(12) + 1e-9
    assert range_from_height((1, 0, 0), 1.0) == pytest.approx((4.25, 7.5 / math.sqrt(12)))


def test_a_sitting_person_is_not_taken_for_one_under_the_lens() -> None:
    """Face 0.9 m high, 3 m away: no standing person can be there, so it must say that it does not know."""
    range_m, sigma = range_from_height((3.0, 0.0, 0.9 - 1.2), 1.2)
    assert sigma > 1.0
    assert abs(range_m - 3.0) < 2 * sigma


def test_an_uncertain_ray_makes_an_uncertain_range() -> None:
    ray = (2.0, 0.0, 0.5)
    assert range_from_height(ray, 1.1, elevation_sigma=0.05)[1] > 1.1 * range_from_height(ray, 1.1)[1]


def test_a_ray_into_the_floor_says_what_was_known_before() -> None:
    assert range_from_height((0.0, 0.0, -1.0), 0.3) == pytest.approx((4.25, 7.5 / math.sqrt(12)))


def test_a_direction_has_a_length() -> None:
    with pytest.raises(ValueError, match="no length"):
        range_from_height((0.0, 0.0, 0.0), 1.0)
