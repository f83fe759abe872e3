"""The dock in a scan: how well its pose is found, and what is not taken for one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, wrap_angle
from app.modules.behaviors.docking.dock_detector import DetectorRules, DockShape, find_dock
from app.modules.behaviors.docking.dock_filter import DockFilter
from tests.modules.behaviors.docking.scans import SHAPE, Segment, plates, seen

RULES = DetectorRules()
BACK: Segment = ((1.45, -2.0), (1.45, 2.0))


def off(expected: Pose2, rng: np.random.Generator) -> Pose2:
    return Pose2(
        expected.x + rng.uniform(-0.25, 0.25),
        expected.y + rng.uniform(-0.25, 0.25),
        wrap_angle(expected.theta + rng.uniform(-0.35, 0.35)),
    )


@pytest.mark.parametrize("distance", [0.4, 0.8, 1.2, 1.8])
def test_ten_scans_give_the_pose_within_a_degree_and_a_centimetre(distance: float) -> None:
    rng = np.random.default_rng(1)
    turns, places = [], []
    for _ in range(20):
        true = Pose2(distance, rng.uniform(-0.1, 0.1), wrap_angle(math.pi + rng.uniform(-0.15, 0.15)))
        dock = DockFilter()
        expected = off(true, rng)
        for number in range(10):
            found = find_dock(seen([*plates(true), ((2.2, -2), (2.2, 2))], rng), expected, SHAPE, RULES)
            assert found is not None
            dock.add(float(number), found)
        assert dock.is_sure
        assert dock.estimate is not None
        turns.append(abs(wrap_angle(dock.estimate.theta - true.theta)))
        places.append(math.hypot(dock.estimate.x - true.x, dock.estimate.y - true.y))
    assert np.degrees(max(turns)) < 1.0
    assert max(places) < 0.01


def test_one_that_is_known_is_refined_without_a_search() -> None:
    rng = np.random.default_rng(2)
    true = Pose2(0.9, 0.05, math.pi - 0.1)
    found = find_dock(seen(plates(true), rng), Pose2(0.92, 0.03, math.pi - 0.05), SHAPE, RULES, search=False)
    assert found is not None
    assert math.hypot(found.x - true.x, found.y - true.y) < 0.01


@pytest.mark.parametrize(
    "segments",
    [
        pytest.param([BACK], id="a wall"),
        pytest.param([((1.2, 0.0), (0.4, 0.8)), ((1.2, 0.0), (0.4, -0.8))], id="a room's square corner"),
        pytest.param(plates(Pose2(1.2, 0, math.pi), DockShape(plate_m=1.0)), id="a room's corner of 120 degrees"),
        pytest.param([*plates(Pose2(1.2, 0, math.pi))[:1], BACK], id="one plate"),
        pytest.param(plates(Pose2(1.2, 0, 0.0)), id="a V that shows its back"),
        pytest.param([], id="nothing"),
    ],
)
def test_what_is_no_dock_is_not_taken_for_one(segments: list[Segment]) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        assert find_dock(seen(segments, rng), off(Pose2(1.2, 0.0, math.pi), rng), SHAPE, RULES) is None


def test_a_dock_beyond_reach_is_another_one() -> None:
    rng = np.random.default_rng(4)
    assert find_dock(seen(plates(Pose2(1.2, 0.0, math.pi)), rng), Pose2(1.2, 0.9, math.pi), SHAPE, RULES) is None


def test_a_foot_in_front_of_a_plate_hides_the_dock() -> None:
    rng = np.random.default_rng(5)
    foot: Segment = ((0.8, 0.02), (0.8, 0.14))
    assert find_dock(seen([*plates(Pose2(1.2, 0, math.pi)), foot], rng), Pose2(1.2, 0, math.pi), SHAPE, RULES) is None


def test_the_filter_ignores_single_outliers_and_follows_a_dock_that_is_elsewhere() -> None:
    dock = DockFilter(sure_after=3)
    for number in range(5):
        dock.add(float(number), Pose2(1.0, 0.0, math.pi))
    dock.add(5.0, Pose2(1.3, 0.0, math.pi))
    assert dock.estimate == Pose2(1.0, 0.0, math.pi) or dock.estimate == Pose2(1.0, 0.0, -math.pi)
    assert dock.stamp == 4.0
    for number in range(10):
        dock.add(6.0 + number, Pose2(1.3, 0.0, math.pi))
    assert dock.estimate is not None
    assert dock.estimate.x == pytest.approx(1.3)
