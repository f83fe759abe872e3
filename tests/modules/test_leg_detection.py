"""Legs in a scan: narrow, in front of their background, and not of the map."""

from __future__ import annotations

import numpy as np

from app.base.geometry import Pose2
from app.modules.leg_detection import legs
from tests.modules.behaviors.navigation.boxes import World

WALL = (3.0, -3.0, 3.2, 3.0, 0.0, 2.5)
SHINS = ((1.5, 0.06, 1.6, 0.16, 0.0, 0.8), (1.5, -0.16, 1.6, -0.06, 0.0, 0.8))


def test_both_shins_are_found_and_neither_a_wall_nor_a_door_post_nor_a_crate() -> None:
    scan = World((WALL, *SHINS)).scan(0.0, Pose2())
    found = legs(scan, 3.0) + np.array([0.2, 0.0])
    assert np.abs(found - np.array([[1.5, -0.11], [1.5, 0.11]])).max() < 0.03
    crate = (1.5, 0.5, 1.9, 1.2, 0.0, 1.0)
    gap = ((2.0, -3.0, 2.1, -0.5, 0.0, 2.0), (2.0, 0.5, 2.1, 3.0, 0.0, 2.0), WALL)
    assert not len(legs(World((WALL, crate)).scan(0.0, Pose2()), 3.0))
    assert not len(legs(World(gap).scan(0.0, Pose2()), 3.0))
    assert not len(legs(World(()).scan(0.0, Pose2()), 3.0))


def test_legs_beyond_the_furthest_range_are_left_out() -> None:
    scan = World((WALL, *SHINS)).scan(0.0, Pose2())
    assert not len(legs(scan, 1.0))
