"""Places in front of posters follow them, and no others."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2, wrap_angle
from app.maps.poster_places import (
    MOVED,
    SAME_M,
    STAND_OFF_M,
    Poster,
    followed,
    in_front_of,
    is_of_poster,
    poster_named,
    posters_of,
)
from app.messages import Landmark, Landmarks, Place

LAB = Poster(3, "tour:lab", 2.0, 1.0, math.pi / 2)
PLACE = in_front_of(Place("lab", "Lab", 0, 0, 0), LAB)
metres, angles = st.floats(-100, 100), st.floats(-math.pi, math.pi)


@given(x=metres, y=metres, heading=angles, distance_m=st.floats(0.3, 5))
def test_in_front_of_it_and_looking_at_it(x: float, y: float, heading: float, distance_m: float) -> None:
    pose = Poster(1, "a", x, y, heading).stand(distance_m)
    assert pose is not None
    assert math.hypot(pose.x - x, pose.y - y) == pytest.approx(distance_m)
    ahead = math.atan2(y - pose.y, x - pose.x)
    assert wrap_angle(pose.theta - ahead) == pytest.approx(0, abs=1e-6)
    # On the side that it is read from.
    assert math.cos(heading) * (pose.x - x) + math.sin(heading) * (pose.y - y) == pytest.approx(distance_m)


def test_a_place_is_bound_to_its_landmark() -> None:
    assert (PLACE.source, PLACE.poster, PLACE.landmark) == ("poster", "tour:lab", 3)
    assert (PLACE.x, PLACE.y, PLACE.heading) == pytest.approx((2.0, 1.0 + STAND_OFF_M, -math.pi / 2), abs=1e-4)


def test_a_poster_of_unknown_heading_has_no_place_yet() -> None:
    with pytest.raises(ValueError, match="which way 'tour:lab' faces"):
        in_front_of(Place("lab", "Lab", 0, 0, 0), replace(LAB, heading=None))
    # A place that has its poster keeps its pose meanwhile.
    assert in_front_of(PLACE, replace(LAB, heading=None)) == PLACE


@given(X=st.builds(Pose2, metres, metres, angles))
def test_as_the_map_is_corrected_it_moves_rigidly_with_its_poster(X: Pose2) -> None:
    at, heading = X @ Pose2(LAB.x, LAB.y, math.pi / 2), X.theta + math.pi / 2
    moved, lack = followed(PLACE, [Poster(3, "tour:lab", at.x, at.y, heading)])
    wanted = X @ Pose2(PLACE.x, PLACE.y, PLACE.heading)
    assert lack == ""
    assert (moved.id, moved.landmark) == ("lab", 3)
    assert math.hypot(moved.x - wanted.x, moved.y - wanted.y) < 2 * MOVED[0]
    assert abs(wrap_angle(moved.heading - wanted.theta)) < 2 * MOVED[1]


def test_what_is_no_news_leaves_it_where_it_is() -> None:
    assert followed(PLACE, [replace(LAB, x=LAB.x + 0.005)]) == (PLACE, "")
    assert followed(PLACE, [replace(LAB, x=LAB.x + 0.05)])[0].x == pytest.approx(PLACE.x + 0.05)


def test_a_poster_found_again_under_another_number_is_taken_where_it_was_and_not_elsewhere() -> None:
    again = replace(LAB, number=8, y=LAB.y + 0.9 * SAME_M)
    far = replace(LAB, number=9, x=LAB.x + 5)
    moved, lack = followed(PLACE, [far, again])
    assert (moved.landmark, lack) == (8, "")
    stays, lack = followed(PLACE, [far])
    assert (stays, lack) == (PLACE, "its poster hangs 5.0 m from where it was: place it again")
    assert is_of_poster(lack)


def test_a_poster_that_is_gone_leaves_the_place_where_it_is() -> None:
    other = Poster(3, "tour:other", 2.0, 1.0, 0.0)  # a number of another map's
    stays, lack = followed(PLACE, [other])
    assert stays == PLACE
    assert lack == "its poster is not known on this map: it was removed, or not seen yet"
    assert is_of_poster(lack)
    assert not is_of_poster("it is in an obstacle of the map")


def test_places_of_hands_follow_nothing() -> None:
    by_hand = Place("lab", "Lab", 1.0, 1.0, 0.0)
    assert followed(by_hand, [LAB]) == (by_hand, "")


def test_landmarks_are_posters_once_they_are_on_the_map() -> None:
    seen = Landmark("tour:lab", (2.0, 1.0, 1.4), 0.05, 3, 1.0, 2.0, heading=0.5, heading_sigma=0.1, id=4)
    assert posters_of(Landmarks(2.0, (seen,), "map")) == (Poster(4, "tour:lab", 2.0, 1.0, 0.5),)
    assert posters_of(Landmarks(2.0, (seen,), "odom")) is None
    assert posters_of(None) is None


def test_of_several_of_one_text_the_nearest_is_meant() -> None:
    far = replace(LAB, number=5, x=9.0)
    assert poster_named([LAB, far], "tour:lab") == LAB
    assert poster_named([LAB, far], "tour:lab", (8.0, 0.0)) == far
    assert poster_named([LAB, far], "tour:kitchen", (8.0, 0.0)) is None
