from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.controller import MotionState
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow
from app.modules.behaviors.navigation.recovery.stall_detector import StallDetector
from tests.modules.behaviors.navigation.scenes import LIMITS, SQUARE, body_of

BODY = body_of(LIMITS, SQUARE)
POSE = Pose2(1.0, 2.0, math.pi / 2)


def free(stamp: float = 0.0) -> CostmapWindow:
    cells = np.zeros((160, 160), dtype=np.int8)
    distance = np.full((160, 160), 8.0, dtype=np.float32)
    return CostmapWindow(stamp, (-1.0, 0.0), 0.025, cells, distance, np.empty((0, 2)), (-1.0, 0.0), 4.0)


def run_into(stall: StallDetector, begin: float = 0.0) -> list[bool]:
    return [stall.update(begin + 0.1 * k, 0.2, MotionState(POSE, 0.0, 0.0)) for k in range(12)]


def test_standing_though_commanded_is_running_into_something_ahead() -> None:
    stall = StallDetector(BODY)
    assert run_into(stall).count(True) == 1
    around = stall.laid_over(free(), 2.0)
    row, column = np.unravel_index(int(around.distance.argmin()), around.distance.shape)
    x, y = -1.0 + (column + 0.5) * 0.025, (row + 0.5) * 0.025
    assert x == pytest.approx(1.0, abs=0.4)
    assert 0.27 < y - 2.0 < 0.45, "before its edge, along where it looks"
    assert around.distance[int(2.0 / 0.025), int(2.0 / 0.025)] > 0.25, "not under itself"
    assert len(around.obstacles) > 5
    assert stall.laid_over(free(), 60.0).distance.min() == 8.0, "it is believed for a while"


def test_commands_that_begin_again_from_standing_against_something_are_felt() -> None:
    stall = StallDetector(BODY)
    commanded = [0.05, 0.09, 0.04, 0.08, 0.12, 0.04, 0.08, 0.04, 0.08, 0.04]
    contacts = [stall.update(0.1 * k, mps, MotionState(POSE, 0.002, 0.0)) for k, mps in enumerate(commanded)]
    assert contacts.count(True) == 1


def test_a_body_that_creeps_as_it_is_commanded_touches_nothing() -> None:
    stall = StallDetector(BODY)
    assert not any(stall.update(0.1 * k, 0.015, MotionState(POSE, 0.015, 0.0)) for k in range(200))


@pytest.mark.parametrize("motion", [MotionState(POSE, 0.1, 0.0), MotionState(POSE, 0.03, 0.5)])
def test_what_moves_touches_nothing(motion: MotionState) -> None:
    stall = StallDetector(BODY)
    assert not any(stall.update(0.1 * k, 0.2, motion) for k in range(30))
    assert not any(stall.update(0.1 * k, 0.0, MotionState(POSE, 0.0, 0.0)) for k in range(30)), (
        "nor what is not commanded"
    )


def test_it_is_forgotten_where_all_is_cleared() -> None:
    stall = StallDetector(BODY)
    run_into(stall)
    stall.clear()
    assert stall.laid_over(free(), 2.0).distance.min() == 8.0
