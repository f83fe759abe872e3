"""Where the robot can stand and go: from the world's own shapes, overhead ones and thin ones included."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from app.base import paths
from app.base.geometry import Pose2
from app.experiments.goals.reachable_floor import CELL_M, survey
from app.robots.config import RobotConfig, load_robot_config
from app.robots.simulated.world_config import WorldConfig
from tests.robots.conftest import make_hall


@pytest.fixture(scope="module")
def robot() -> RobotConfig:
    """The robot as shipped."""
    return load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")


@pytest.fixture(scope="module")
def divided() -> WorldConfig:
    """A hall cut in two by a wall along x = 10 with a door of 1 m at y = 5, a table and a carpet in its west half."""
    wall = {"from": (10, 0), "to": (10, 20), "material": "wall", "thickness": 0.2, "doors": [{"at": 5.0}]}
    corners = [(0, 0), (20, 0), (20, 20), (0, 20), (0, 0)]
    outside = [{"from": a, "to": b, "material": "wall", "thickness": 0.2} for a, b in itertools.pairwise(corners)]
    return make_hall(
        walls=[*outside, wall],
        areas=[{"from": (3, 3), "to": (5, 5), "material": "floor"}],
        objects=[{"kind": "table", "at": (5.0, 15.0), "size": (2.0, 1.0, 0.8)}],
    )


def test_rooms_are_joined_by_doors_and_things_are_in_the_way(robot: RobotConfig, divided: WorldConfig) -> None:
    ground = survey(divided, robot)
    assert ground.room.shape == (400, 400)

    def room(x: float, y: float) -> float:
        return float(ground.room[int(y / CELL_M), int(x / CELL_M)])

    assert room(4.0, 4.0) == pytest.approx(3.9, abs=0.1)  # a carpet is no obstacle, the wall at x = 0.1 is
    assert room(5.0, 15.0) == 0.0  # under the table's top
    assert room(6.5, 15.0) == pytest.approx(0.5, abs=0.06)
    assert room(10.0, 5.0) == pytest.approx(0.45, abs=0.06)  # the door's posts, not its lintel
    assert room(10.0, 12.0) == 0.0

    through = ground.reachable(Pose2(4, 4), 0.40)
    assert through[int(12 / CELL_M), int(15 / CELL_M)]
    too_wide = ground.reachable(Pose2(4, 4), 0.50)
    assert not too_wide[int(12 / CELL_M), int(15 / CELL_M)]
    with pytest.raises(ValueError, match=r"there is no room of 0\.40 m around"):
        ground.reachable(Pose2(5, 15), 0.40)


def test_goals_are_reachable_apart_and_the_same_for_a_seed(robot: RobotConfig, divided: WorldConfig) -> None:
    ground = survey(divided, robot)
    start = Pose2(4, 4)
    cells = ground.reachable(start, 0.40)
    goals = ground.draw(cells, 200, start, 2.0, np.random.default_rng(3))
    assert goals == ground.draw(cells, 200, start, 2.0, np.random.default_rng(3))
    for before, goal in zip([start, *goals], goals, strict=False):
        assert math.dist((before.x, before.y), (goal.x, goal.y)) >= 2.0
        assert cells[int(goal.y / CELL_M), int(goal.x / CELL_M)]
    assert {goal.x > 10 for goal in goals} == {True, False}
