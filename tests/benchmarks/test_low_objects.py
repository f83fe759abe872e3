"""When a low object counts as known, and as known in time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.base.yaml_source import parse
from app.robots.simulated.world_config import WorldConfig
from benchmarks.low_objects import LowObject, low_objects, tour

NOTHING = np.empty((0, 2))


def box() -> LowObject:
    return LowObject("box", Pose2(2.0, 0.0, math.pi / 2), (0.4, 0.2))


def test_distances_are_to_the_outline() -> None:
    points = np.array([[2.0, 0.15], [2.0, 0.5], [1.0, 0.0], [2.4, 0.6]])
    assert box().distances(points) == pytest.approx([0.0, 0.3, 0.9, 0.5])


def test_two_cells_on_its_outline_make_it_known_from_where_the_robot_is() -> None:
    it = box()
    it.observe(Pose2(), np.array([[1.9, 0.0], [0.5, 0.5]]))
    assert it.known_m is None
    it.observe(Pose2(), np.array([[1.9, 0.0], [1.9, 0.05]]))
    assert it.known_m == pytest.approx(1.9)
    it.observe(Pose2(0.95, 0.0, 0.0), NOTHING)
    assert (it.in_time, it.nearest_m) == (True, pytest.approx(0.95))


def test_one_that_is_found_when_the_robot_is_near_is_late_and_one_passed_far_off_is_neither() -> None:
    late, far = box(), box()
    late.observe(Pose2(1.2, 0.0, 0.0), NOTHING)
    late.observe(Pose2(1.2, 0.0, 0.0), np.array([[1.9, 0.0], [1.9, 0.05]]))
    assert (late.in_time, late.known_m) == (False, pytest.approx(0.7))
    far.observe(Pose2(), NOTHING)
    assert far.in_time is None


def test_the_labs_low_objects_are_those_that_the_laser_passes_over_and_the_tour_is_not_led_to_all_of_them() -> None:
    found = low_objects(parse(config_dir() / "worlds" / "lab.yaml", WorldConfig))
    kinds = {each.name.partition(" ")[0] for each in found}
    assert {"box", "crate", "suitcase", "stool"} <= kinds
    assert not {"sofa", "picture", "window", "desk"} & kinds
    assert not [leg for leg in tour(quick=False) if leg.label.startswith("towards the crate")]
