"""The states of docking, stepped with values."""

from __future__ import annotations

import math
from typing import Any

import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.docking.docking_sequence import STOP, DockingInput, DockingSequence, SequenceRules

RULES = SequenceRules()
#: The dock's pose in odom; the robot looks at it along x.
X_OD = Pose2(2.0, 0.0, math.pi)
FRONT = Pose2(0.8, 0.0, 0.0)
IN_DOCK = Pose2(2.0 - RULES.approach.docked_m + 0.005, 0.0, 0.0)


class Robot:
    """A sequence, and what it knows; time goes on by a tenth of a second with each step."""

    def __init__(self) -> None:
        self.sequence = DockingSequence(RULES)
        self.now = 0.0
        self.known: dict[str, Any] = {
            "X_OB": FRONT, "wanted": True, "leave": False, "charging": False, "at_staging": False
        }  # fmt: skip

    def step(self, **changes: Any) -> tuple[float, float] | None:
        self.known |= changes
        self.now += 0.1
        return self.sequence.step(DockingInput(self.now, **self.known))

    def steps(self, seconds: float, **changes: Any) -> tuple[float, float] | None:
        for _ in range(round(seconds / 0.1)):
            velocity = self.step(**changes)
        return velocity

    def approaching(self) -> None:
        self.step()
        self.step(at_staging=True)
        self.step(X_OD=X_OD, seen_s=0.1)
        assert self.sequence.state == "approaching"

    def docked(self) -> None:
        self.approaching()
        self.step(X_OB=IN_DOCK, charging=True)
        assert self.sequence.state == "docked"


def test_it_goes_there_looks_for_the_dock_drives_in_and_holds_while_it_charges() -> None:
    robot = Robot()
    assert robot.step() is None
    assert robot.sequence.needs_way
    assert robot.step() is None
    assert robot.step(at_staging=True) == STOP
    assert not robot.sequence.needs_way
    assert robot.step() == STOP
    assert robot.step(X_OD=X_OD, seen_s=0.0) == STOP
    assert robot.step() == pytest.approx((RULES.approach.fast_mps, 0.0))
    assert robot.step(X_OB=Pose2(1.5, 0, 0)) == pytest.approx((RULES.approach.slow_mps, 0.0))
    assert robot.step(X_OB=IN_DOCK, charging=True) == STOP
    assert robot.steps(5) == STOP
    assert robot.sequence.state == "docked"
    assert robot.sequence.attempt == 1


def test_a_place_in_front_of_the_dock_that_is_not_reached_is_a_failure_with_its_reason() -> None:
    robot = Robot()
    robot.step()
    assert robot.step(unreachable="a wall is around it") is None
    assert robot.sequence.state == "failed"
    assert robot.sequence.reason == "the place in front of the dock was not reached: a wall is around it"
    robot.sequence.again()
    robot.step(unreachable="")
    assert robot.sequence.state == "going"


def test_a_dock_that_is_not_seen_fails() -> None:
    robot = Robot()
    robot.step()
    robot.steps(RULES.search_s + 0.5, at_staging=True)
    assert (robot.sequence.state, robot.sequence.reason) == ("failed", "no dock is seen where it should be")


@pytest.mark.parametrize(
    ("what", "seconds", "why"),
    [
        ({"X_OB": Pose2(1.62, 0, 0)}, 3.0, "the charger gives no power"),
        ({"X_OB": Pose2(1.57, 0.06, 0)}, 0.1, "it stood askew in front of the dock"),
        ({"X_OB": Pose2(1.57, 0.0, 0.2)}, 0.1, "it stood askew in front of the dock"),
        ({"X_OB": Pose2(1.3, 0, 0), "seen_s": 2.0}, 0.1, "the dock was lost from sight"),
        ({"X_OB": Pose2(1.3, 0, 0)}, 4.0, "something holds it in front of the dock"),
    ],
)
def test_an_approach_that_goes_wrong_is_tried_again_further_back(
    what: dict[str, Any], seconds: float, why: str
) -> None:
    robot = Robot()
    robot.approaching()
    robot.steps(seconds, **what)
    assert (robot.sequence.state, robot.sequence.reason) == ("backing", why)
    assert robot.sequence.attempt == 2
    assert robot.step() == (-RULES.back_mps, 0.0)
    robot.step(X_OB=Pose2(2.0 - RULES.staging_m, 0, 0))
    assert robot.sequence.state == "searching"


def test_after_three_attempts_it_gives_up() -> None:
    robot = Robot()
    robot.approaching()
    for _ in range(RULES.attempts):
        robot.steps(3.0, X_OB=Pose2(1.62, 0, 0))
        if robot.sequence.state == "failed":
            break
        robot.steps(0.3, X_OB=FRONT)
        assert robot.sequence.state == "approaching"
    assert robot.sequence.state == "failed"
    assert robot.sequence.reason == "the charger gives no power, after 3 attempts"


def test_something_behind_it_ends_backing_off() -> None:
    robot = Robot()
    robot.approaching()
    robot.steps(3.0, X_OB=Pose2(1.62, 0, 0))
    robot.steps(3 * RULES.staging_m / RULES.back_mps + 1)
    assert robot.sequence.state == "failed"
    assert "something behind it" in robot.sequence.reason


def test_it_drives_back_half_a_metre_when_it_is_called_away_also_without_a_desire_for_the_dock() -> None:
    robot = Robot()
    robot.docked()
    assert robot.step(wanted=False) is None
    assert robot.sequence.state == "docked"
    robot.step(leave=True)
    assert robot.step() == (-RULES.back_mps, 0.0)
    assert robot.step(X_OB=Pose2(IN_DOCK.x - 0.4, 0, 0)) == (-RULES.back_mps, 0.0)
    assert robot.step(X_OB=Pose2(IN_DOCK.x - 0.51, 0, 0), charging=False) is None
    assert robot.sequence.state == "idle"


def test_called_away_between_the_plates_it_drives_back_first_and_further_off_it_just_leaves_off() -> None:
    near, far = Robot(), Robot()
    near.approaching()
    near.step(X_OB=Pose2(1.5, 0, 0), wanted=False, leave=True)
    assert near.sequence.state == "undocking"
    far.approaching()
    assert far.step(wanted=False, leave=True) is None
    assert far.sequence.state == "idle"


def test_a_charge_that_flickers_is_none_that_ends() -> None:
    robot = Robot()
    robot.docked()
    robot.steps(1.0, charging=False)
    robot.step(charging=True)
    assert robot.sequence.state == "docked"
    robot.steps(3.0, charging=False)
    assert robot.sequence.state == "backing"


def test_a_robot_that_begins_on_the_dock_is_docked() -> None:
    robot = Robot()
    robot.step(X_OB=IN_DOCK, charging=True)
    assert robot.sequence.state == "docked"
