"""Whether the robot could stand at a place."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.maps.place_checks import Surroundings, doubt, inscribed_radius_m, judged, obstruction
from app.maps.poster_places import Poster
from app.messages import OccupancyGrid, Place, Zone, read_only
from tests.maps.grids import room

#: Free from (-0.7, 2.8) to (0.7, 4.2), with a pillar from (0.0, 3.1) to (0.2, 3.25).
GRID = room()
STAIRS = Zone("stairs", "keep_out", read_only(np.array([[-0.7, 3.8], [-0.3, 3.8], [-0.3, 4.2], [-0.7, 4.2]])), 1.0)
SLOW = Zone("door", "slow", STAIRS.polygon, 0.5)


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        (-0.4, 3.2, ""),
        (0.1, 3.2, "it is in an obstacle of the map"),
        (-0.15, 3.2, "it is in an obstacle of the map"),  # the pillar begins 0.15 m from there
        (-0.25, 3.2, ""),
        (-0.5, 4.0, "it is in the keep-out zone stairs"),
    ],
)
def test_obstacles_and_zones(x: float, y: float, words: str) -> None:
    assert obstruction(Pose2(x, y, 0), GRID, [SLOW, STAIRS], 0.2) == words


def test_a_robot_without_extent_is_where_its_cell_is() -> None:
    assert obstruction(Pose2(0.1, 3.2, 0), GRID, [], 0.0) == "it is in an obstacle of the map"
    assert obstruction(Pose2(-0.02, 3.2, 0), GRID, [], 0.0) == ""


def test_without_a_map_there_are_zones_alone() -> None:
    assert obstruction(Pose2(0.1, 3.2, 0), None, [], 0.3) == ""
    assert "stairs" in obstruction(Pose2(-0.5, 4.0, 0), None, [STAIRS], 0.3)
    assert doubt(Pose2(99, 99, 0), None) == ""


def test_what_the_map_does_not_know() -> None:
    assert doubt(Pose2(0.4, 3.6, 0), GRID) == ""
    assert doubt(Pose2(-0.95, 2.55, 0), GRID) == "it is where the map is not known"
    assert doubt(Pose2(5.0, 3.0, 0), GRID) == "it is beyond the map"


@given(x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3), radius_m=st.floats(0, 3))
def test_the_cells_are_those_of_the_disc(x: float, y: float, radius_m: float) -> None:
    cells = np.zeros((9, 7), np.int8)
    cells[4, 3] = 100  # its middle is at (1.75, 2.25)
    grid = OccupancyGrid(0.0, "map", read_only(cells), 0.5, (0.0, 0.0), 1)
    inside = math.hypot(x - 1.75, y - 2.25) <= radius_m or (1.5 <= x < 2.0 and 2.0 <= y < 2.5)
    near_the_edge = abs(math.hypot(x - 1.75, y - 2.25) - radius_m) < 1e-9
    assert near_the_edge or (obstruction(Pose2(x, y, 0), grid, [], radius_m) != "") == inside


def test_the_greatest_disc_in_a_footprint() -> None:
    assert inscribed_radius_m([(0.3, 0.2), (-0.25, 0.2), (-0.25, -0.2), (0.3, -0.2)]) == pytest.approx(0.2)
    assert inscribed_radius_m([]) == 0.0


def test_what_is_worst_is_said_first() -> None:
    lost = Place("a", "A", 0.1, 3.2, 0.0, "poster", "tour:a", 1)
    around = Surroundings([Poster(2, "tour:b", 0, 0, 0.0)], GRID, [STAIRS], radius_m=0.2)
    free = Place("b", "B", 0.4, 3.6, 0.0, "poster", "tour:a", 1)
    by_hand = Place("c", "C", 0.4, 3.6, 0.0)
    problems = [place.problem for place in judged([lost, free, by_hand], around)]
    assert problems == [
        "it is in an obstacle of the map",
        "its poster is not known on this map: it was removed, or not seen yet",
        "",
    ]
    unknown = Surroundings(None, GRID, [], radius_m=0.2)
    assert judged([free], unknown)[0].problem == "", "posters are not known on the map yet"
