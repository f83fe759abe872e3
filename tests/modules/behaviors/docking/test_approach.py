"""The approach to a dock, on a base that obeys, with measurements that err."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, wrap_angle
from app.modules.behaviors.docking.approach import ApproachRules, approach, offset_of

RULES = ApproachRules()


def test_offsets_are_those_of_a_robot_that_looks_at_the_dock() -> None:
    # The robot stands left of the axis, as it looks at the dock, and is turned to its left.
    offset = offset_of(Pose2(1.39, -0.1, wrap_angle(math.pi + 0.2)), RULES)
    assert offset.remaining_m == pytest.approx(1.0)
    assert offset.aside_m == pytest.approx(0.1)
    assert offset.turned_rad == pytest.approx(0.2)


def test_it_crawls_at_last_and_turns_first_where_it_looks_away() -> None:
    assert approach(offset_of(Pose2(1.2, 0, math.pi), RULES), RULES) == (RULES.fast_mps, 0.0)
    assert approach(offset_of(Pose2(0.6, 0, math.pi), RULES), RULES) == (RULES.slow_mps, 0.0)
    linear, angular = approach(offset_of(Pose2(1.2, 0, math.pi - 0.8), RULES), RULES)
    assert linear == 0.0
    assert angular == RULES.turn_radps


@pytest.mark.parametrize("seed", range(5))
def test_it_ends_on_the_axis_though_measurements_err(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(40):
        x, y, theta = 1.2, rng.uniform(-0.2, 0.2), math.pi + rng.uniform(-0.3, 0.3)
        while x > RULES.docked_m:
            measured = Pose2(x, y + rng.normal(0, 0.005), wrap_angle(theta + rng.normal(0, 0.02)))
            linear, angular = approach(offset_of(measured, RULES), RULES)
            x, y = x + 0.1 * linear * math.cos(theta), y + 0.1 * linear * math.sin(theta)
            theta += 0.1 * angular
        assert abs(y) < 0.03
        assert abs(wrap_angle(theta - math.pi)) < math.radians(4)
