"""Where to stand: at the distance, facing the person, and by ways that keep it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import wrap_angle
from app.modules.behaviors.follow.standing import (
    IN_FRONT_RAD,
    Point,
    bearing,
    behind,
    in_front,
    is_in_front,
    nearing_mps,
    share_of_speed,
)

coordinates = st.floats(-20, 20)
points = st.tuples(coordinates, coordinates)
angles = st.floats(-math.pi, math.pi)
distances = st.floats(0.8, 5)


def nearest_m(start: Point, end: Point, point: Point) -> float:
    """Least distance of the straight way from ``start`` to ``end`` to ``point``."""
    way = complex(*end) - complex(*start)
    to = complex(*point) - complex(*start)
    share = 0.0 if abs(way) == 0 else min(1.0, max(0.0, (to * way.conjugate()).real / abs(way) ** 2))
    return abs(to - share * way)


@given(robot=points, person=points, distance_m=distances)
def test_behind_it_comes_as_near_as_the_distance_and_does_not_back_away(
    robot: Point, person: Point, distance_m: float
) -> None:
    place = behind(robot, person, distance_m)
    before, after = math.dist(robot, person), math.dist((place.x, place.y), person)
    assert after == pytest.approx(min(before, distance_m), abs=1e-6)
    assert math.dist(robot, (place.x, place.y)) == pytest.approx(max(0.0, before - distance_m), abs=1e-6)
    if before > 1e-3:
        assert abs(wrap_angle(place.theta - bearing(robot, person))) < 1e-6


@given(
    person=points, facing=angles, distance_m=distances, away_m=st.floats(0, 10), direction=angles, spin=st.booleans()
)
def test_the_way_to_the_front_keeps_the_distance_and_ends_before_the_face(
    person: Point, facing: float, distance_m: float, away_m: float, direction: float, spin: bool
) -> None:
    radius_m = distance_m + away_m
    robot = person[0] + radius_m * math.cos(direction), person[1] + radius_m * math.sin(direction)
    for _ in range(12):
        place = in_front(robot, person, facing, distance_m)
        end = (place.x, place.y)
        # Within what counts as in front, the straight way is a little nearer.
        assert nearest_m(robot, end, person) >= distance_m * math.cos(IN_FRONT_RAD / 2) - 1e-6
        if math.dist(robot, end) < 1e-6:
            break
        robot = end
    assert is_in_front(robot, person, facing)
    assert math.dist(robot, person) == pytest.approx(distance_m, abs=1e-6)
    assert abs(wrap_angle(place.theta - bearing(robot, person))) < 1e-6


def test_in_front_and_nearer_it_stays_and_turns_to_the_person() -> None:
    place = in_front((0.0, 0.1), (0.9, 0.0), math.pi, 1.2)
    assert (place.x, place.y) == (0.0, 0.1)
    assert place.theta == pytest.approx(math.atan2(-0.1, 0.9))


def test_beside_the_person_and_nearer_it_goes_out_first() -> None:
    place = in_front((0.0, -0.9), (0.0, 0.0), 0.0, 1.2)
    assert math.hypot(place.x, place.y) > 1.2
    assert place.x > 0, "the shorter way round"


@given(gap_m=st.floats(0, 5), braking=st.floats(0.1, 3), delay_s=st.floats(0, 1))
def test_from_the_allowed_speed_it_stops_before_the_place(gap_m: float, braking: float, delay_s: float) -> None:
    speed = nearing_mps(gap_m, braking, delay_s)
    assert speed >= 0
    assert speed * delay_s + speed**2 / (2 * braking) <= gap_m + 1e-9
    faster = speed + 0.01
    assert faster * delay_s + faster**2 / (2 * braking) > gap_m


@given(
    velocity=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    aside=angles,
    nearest_mps=st.floats(0, 1, allow_subnormal=False),
)
def test_no_more_than_needed_is_taken_of_the_speed(
    velocity: tuple[float, float], aside: float, nearest_mps: float
) -> None:
    share = share_of_speed(velocity, aside, nearest_mps)
    assert 0 <= share <= 1
    nearing = velocity[0] * math.cos(aside) + velocity[1] * math.sin(aside)
    assert share * nearing <= nearest_mps + 1e-9
    assert share == 1 or share * nearing == pytest.approx(nearest_mps)


def test_nothing_but_the_distance_limits_a_command_away_or_along() -> None:
    assert nearing_mps(-0.2, 0.4, 0.3) == 0
    assert share_of_speed((-0.3, 0.0), 0.0, 0.0) == 1
    assert share_of_speed((0.3, 0.0), math.pi / 2 + 0.01, 0.0) == 1
    assert share_of_speed((0.3, 0.0), 0.2, 0.0) == 0
