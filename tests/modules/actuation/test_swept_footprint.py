"""When a footprint on an arc meets points: against stepping along the arc, which needs no geometry to be right."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from app.modules.actuation.swept_footprint import Points, Polygon, contact_times, may_decide
from app.robots.actuator_config import circle

ROUND = circle(0.28)
BOX = ((0.254, -0.215), (0.254, 0.215), (-0.254, 0.215), (-0.254, -0.215))
TRIANGLE = ((0.6, 0.0), (-0.2, 0.25), (-0.2, -0.35))
SHAPES = (ROUND, BOX, TRIANGLE)
HORIZON_S = 2.0

points = st.lists(st.complex_numbers(max_magnitude=1.5), min_size=1, max_size=12).map(np.array)
velocities = st.one_of(
    st.sampled_from([-2.0, -0.3, 0.0, 0.05, 0.4, 2.0]).map(complex), st.complex_numbers(max_magnitude=2.0)
)
angulars = st.sampled_from([-4.0, -1.0, -0.1, -1e-5, 0.0, 1e-3, 0.2, 1.0, 3.0])


def stepped(
    point: complex, polygon: Polygon, velocity: complex, angular: float, steps: int = 2000
) -> tuple[float, float]:
    """When ``point`` is first seen inside, and how deep the pose before was from inside (m, negative: outside)."""
    times = np.linspace(0.0, HORIZON_S, steps + 1)
    half = angular * times / 2
    # The pose on the arc: a chord along half its turn.
    place = velocity * times * np.sinc(half / math.pi) * np.exp(1j * half)
    seen = (point - place) * np.exp(-2j * half)
    beyond = polygon.edgewise(seen).max(axis=1)
    inside = np.flatnonzero(beyond < 0)
    return (math.inf if not len(inside) else float(times[inside[0]])), float(beyond.min())


@given(st.sampled_from(SHAPES), st.sampled_from([0.0, 0.05]), points, velocities, angulars)
def test_contact_is_where_stepping_along_the_arc_finds_it(
    corners: tuple[tuple[float, float], ...], margin_m: float, cloud: Points, velocity: complex, angular: float
) -> None:
    polygon = Polygon.of(corners, margin_m)
    if angular == 0.0 and velocity == 0.0:
        return
    times = contact_times(cloud, polygon, velocity, angular, HORIZON_S)
    step_s = HORIZON_S / 2000
    speed = abs(velocity) + abs(angular) * 2.0
    for point, time in zip(cloud, times, strict=True):
        found, nearest = stepped(complex(point), polygon, velocity, angular)
        if abs(nearest) < speed * step_s + 2e-3:
            continue  # it is brushed, or only just not
        if math.isinf(found):
            assert math.isinf(time)
        else:
            # Between two steps it may have been in and out again: the exact one may only be earlier.
            assert time <= found + 1e-6
            entered = cmath.rect(1.0, -angular * time) * (complex(point) - _place(velocity, angular, time))
            # A turn of 1e-5 rad/s leaves 1.5e-5 m to rounding.
            assert polygon.edgewise(np.array([entered])).max() <= 5e-5


def _place(velocity: complex, angular: float, time: float) -> complex:
    half = angular * time / 2
    return complex(velocity * time * np.sinc(half / math.pi) * cmath.exp(1j * half))


@given(st.sampled_from(SHAPES), points, velocities, angulars, st.integers(1, 3))
@example(TRIANGLE, np.array([0j, 0j, 0j, 0.5j]), -2.0 + 0j, -4.0, 1)  # a point where the body turns around
def test_a_closer_look_at_few_finds_the_same_first_contacts(
    corners: tuple[tuple[float, float], ...], cloud: Points, velocity: complex, angular: float, evidence: int
) -> None:
    if angular == 0.0 and velocity == 0.0:
        return
    tight, grown = Polygon.of(corners), Polygon.of(corners, 0.05)
    near = may_decide(cloud, tight, grown, velocity, angular, HORIZON_S, evidence)
    every = contact_times(cloud, grown, velocity, angular, HORIZON_S)
    hits = every[contact_times(cloud, tight, velocity, angular, HORIZON_S) < math.inf]
    some = every[near]
    surest = np.sort(hits)[evidence - 1] if len(hits) >= evidence else math.inf
    wanted = np.sort(every[every < surest])
    assert np.isin(wanted, some).all(), "whatever is met before the first sure contacts is among those looked at"
    if len(hits) >= evidence:
        assert np.sort(some)[evidence - 1] == np.sort(every)[evidence - 1]


def test_the_margin_moves_every_edge_out() -> None:
    grown = Polygon.of(BOX, 0.1)
    assert grown.inner == pytest.approx(0.315)
    assert grown.outer == pytest.approx(math.hypot(0.354, 0.315))
    beyond, _ = Polygon.of(BOX).beyond(np.array([0.304 + 0j, 0.0 - 0.2j]))
    assert beyond == pytest.approx([0.05, -0.015])


@pytest.mark.parametrize(
    "corners",
    [
        ((0.2, 0.0), (-0.2, 0.0)),
        tuple(reversed(BOX)),
        ((0.2, 0.2), (0.0, 0.1), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)),
        ((0.2, 0.1), (0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1)),
        ((1.2, -0.1), (1.2, 0.1), (1.0, 0.1), (1.0, -0.1)),
    ],
)
def test_what_is_no_footprint_is_refused(corners: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ValueError, match="footprint"):
        Polygon.of(corners)


@pytest.mark.parametrize("velocity", [1.6e-81 + 0j, 5e-324j, 1e-12 + 0j])
def test_a_velocity_beyond_rounding_is_none(velocity: complex) -> None:
    polygon = Polygon.of(SHAPES[0], 0.0)
    times = contact_times(np.array([0j, 5.0 + 0j]), polygon, velocity, -1e-5, HORIZON_S)
    assert times.tolist() == [0.0, math.inf]
