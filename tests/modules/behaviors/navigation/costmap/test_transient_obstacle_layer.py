from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.costmap.inflation import cost_field, with_obstacles
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow
from app.modules.behaviors.navigation.costmap.transient_obstacle_layer import TransientObstacles, remember
from tests.modules.behaviors.navigation.maps import ROUND, office

FIELD = cost_field(office(), ROUND)
#: odom lies turned on the map.
X_MO = Pose2(5.0, 4.3, math.pi / 2)


def around(stamp: float, on_map: list[tuple[float, float]], robot: Pose2) -> CostmapWindow:
    """The costmap of obstacles at places of the map, around the robot; its grid is 8 m wide."""
    X_OM = X_MO.inverse()
    places = np.array([[(X_OM @ Pose2(x, y)).x, (X_OM @ Pose2(x, y)).y] for x, y in on_map]).reshape(-1, 2)
    here = X_OM @ robot
    cells = np.zeros((160, 160), np.int8)
    corner = (here.x - 4.0, here.y - 4.0)
    return CostmapWindow(stamp, corner, 0.025, cells, cells.astype(np.float32), places, corner, 8.0)


def test_what_is_not_on_the_map_is_remembered_on_the_map() -> None:
    known = remember(TransientObstacles.none(), around(1.0, [(6.5, 4.3)], Pose2(5, 4.3, 0)), X_MO, FIELD)
    assert known.points == pytest.approx(np.array([[6.525, 4.325]]), abs=0.051)
    assert known.stamps.tolist() == [1.0]


def test_walls_are_not_obstacles_twice() -> None:
    walls = [(6.0, 5.28), (6.0, 5.22), (7.0, 3.48)]
    assert not len(remember(TransientObstacles.none(), around(1.0, walls, Pose2(5, 4.3, 0)), X_MO, FIELD).points)


def test_who_went_away_is_forgotten_where_the_robot_looks_and_later_where_it_does_not() -> None:
    known = remember(TransientObstacles.none(), around(1.0, [(6.5, 4.3)], Pose2(5, 4.3, 0)), X_MO, FIELD)
    assert not len(remember(known, around(1.5, [], Pose2(5, 4.3, 0)), X_MO, FIELD).points)
    beyond = Pose2(12, 4.3, 0)
    assert len(remember(known, around(8.0, [], beyond), X_MO, FIELD).points) == 1
    assert not len(remember(known, around(16.5, [], beyond), X_MO, FIELD).points)


def test_temporary_obstacles_of_the_field_are_not_of_the_map() -> None:
    seen = around(1.0, [(6.5, 4.3)], Pose2(5, 4.3, 0))
    known = remember(TransientObstacles.none(), seen, X_MO, FIELD)
    again = remember(known, seen, X_MO, with_obstacles(FIELD, known.points))
    assert np.array_equal(again.points, known.points)


def test_off_the_map_nothing_is_remembered() -> None:
    assert not len(remember(TransientObstacles.none(), around(1.0, [(-2.0, 4.3)], Pose2(1, 4, 0)), X_MO, FIELD).points)
