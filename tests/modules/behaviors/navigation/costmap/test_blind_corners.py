from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.controller import DistanceField
from app.modules.behaviors.navigation.costmap.blind_corners import careful, hidden_distance
from tests.modules.behaviors.navigation.scenes import LIMITS, way_along

RESOLUTION = 0.025


def corner() -> np.ndarray:
    """4 x 4 m: a corridor along x, free and seen, under a wall; a doorway at x 2.4 to 3.2, behind it unseen."""
    cells = np.full((160, 160), -1, dtype=np.int8)
    cells[40:100, :] = 0
    cells[38:40, :] = cells[100:102, :] = 100
    cells[100:102, 96:128] = 0
    return cells


def test_what_is_unseen_behind_a_wall_is_no_corner_but_a_doorway_is() -> None:
    hidden = hidden_distance(corner(), RESOLUTION)
    assert hidden[101, 112] == pytest.approx(0.0, abs=0.06)
    assert hidden[70, 112] == pytest.approx(0.8, abs=0.06)
    assert hidden[70, 10] > 2.0
    assert hidden_distance(np.zeros((160, 160), dtype=np.int8), RESOLUTION).min() == 1e3


def test_gaps_between_rays_are_no_corners() -> None:
    cells = np.zeros((160, 160), dtype=np.int8)
    cells[::7, ::5] = -1
    assert hidden_distance(cells, RESOLUTION).min() == 1e3


def test_it_goes_slower_past_the_doorway_and_as_fast_as_ever_elsewhere() -> None:
    hidden = hidden_distance(corner(), RESOLUTION)
    field = DistanceField(np.ones((160, 160), dtype=np.float32), (0.0, 0.0), RESOLUTION, hidden)
    way = way_along([(0.2, 2.3), (3.9, 2.3), (6.0, 2.3)], Pose2(0.2, 2.3, 0.0), LIMITS)
    slowed = careful(way, field, hidden, 0.4, 0.5, 1.0)
    speed = dict(zip(np.round(slowed.points[:, 0], 2).tolist(), slowed.points[:, 4].tolist(), strict=True))
    assert speed[0.5] == pytest.approx(0.4)
    past = min(value for x, value in speed.items() if 2.4 < x < 3.2)
    assert 0.2 < past < 0.3
    assert slowed.points[:, 3].tolist() == way.points[:, 3].tolist()
