"""The visitors of a rehearsal: where they stand at its begin."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, wrap_angle
from app.maps.grid_rays import GridRays
from app.messages import OccupancyGrid
from app.rehearsal.visitors import AWAY_M, visitors
from tests.robots.simulated.kinematic.rooms import room


def test_they_stand_ahead_of_the_robot_and_look_at_it() -> None:
    start = Pose2(0.0, 0.0)
    people = visitors(3, start, GridRays(room())).people
    assert [person.name for person in people] == ["visitor 1", "visitor 2", "visitor 3"]
    for person in people:
        x, y = person.at
        assert math.hypot(x, y) == pytest.approx(AWAY_M)
        assert abs(math.atan2(y, x)) < 1.0
        towards = math.atan2(-y, -x)
        assert wrap_angle(math.radians(person.heading_deg) - towards) == pytest.approx(0.0, abs=1e-9)
    assert len({person.at for person in people}) == 3


def test_they_stand_in_no_wall_and_behind_none() -> None:
    rays, start = GridRays(room()), Pose2(3.9, 0.0)
    people = visitors(8, start, rays).people
    assert people
    for person in people:
        assert rays.clear_m(*person.at) >= 0.3
        assert rays.sees((start.x, start.y), person.at)
    narrow = Pose2(-0.6, 1.6)
    assert len(visitors(8, narrow, rays).people) < 8


def test_none_are_none() -> None:
    assert visitors(0, Pose2(), GridRays(room())).people == ()


def test_in_a_narrow_place_they_stand_in_two_rows() -> None:
    cells = np.full((26, 120), 100, np.int8)
    cells[4:22, 50:] = 0
    dead_end = GridRays(OccupancyGrid(0.0, "map", cells, 0.05, origin=(-3.0, -0.65), version=1))
    people = visitors(2, Pose2(0.0, 0.0, 0.0), dead_end).people
    assert [round(math.dist((0, 0), person.at), 1) for person in people] == [1.5, 2.2]
