"""Room is left beside legs, which are narrower than their person; posts of the map are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.base.geometry import Pose2, Pose3
from app.modules.behaviors.navigation.costmap.leg_inflation import beside
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.behaviors.navigation.boxes import World

GRID = mapped([*box(0.1, 0.1, 7.9, 7.9), (3.0, 2.0, 3.05, 2.0)], (0.0, 0.0, 8.0, 8.0))


def test_room_is_left_around_legs_but_not_around_a_post_of_the_map() -> None:
    X_MO, X_OB = Pose2(1.0, 1.0, 0.0), Pose2(0.3, 1.0, 0.0)
    scan = World(((2.0, 0.95, 2.1, 1.05, 0.0, 2.0), (1.5, 0.2, 1.6, 0.3, 0.0, 2.0))).scan(0.0, X_OB)
    room = beside(scan, X_OB, X_MO, GRID, 0.1)
    assert len(room) == 12, "the one at (3.0, 2.0) on the map is a post"
    assert np.abs(np.hypot(*(room - np.array([1.5, 0.25])).T) - 0.1).max() < 0.06, "about its near side"


def test_a_laser_mounted_upside_down_has_them_on_the_other_side() -> None:
    X_MO, X_OB = Pose2(1.0, 1.0, 0.0), Pose2(0.3, 1.0, 0.0)
    scan = World(((1.5, 0.2, 1.6, 0.3, 0.0, 2.0),)).scan(0.0, X_OB)
    hung = replace(
        scan,
        ranges=scan.ranges[::-1],
        X_BL=scan.X_BL @ Pose3.from_translation_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)),
    )
    room, same = (beside(s, X_OB, X_MO, GRID, 0.1) for s in (scan, hung))
    assert np.abs(room.mean(axis=0) - same.mean(axis=0)).max() < 0.01
