"""Grippers that close on something, on nothing, and open."""

from __future__ import annotations

import pytest

from app.modules.behaviors.gestures.gesture import GestureStep, Servo
from app.modules.behaviors.gestures.gripping import GripGesture
from tests.modules.actuation.arms import GROUPS
from tests.modules.behaviors.gestures.ideal_arms import PERIOD_S, IdealBody

GRIPPER = GROUPS["left_gripper"]
JOINT = GRIPPER.joints[0]


class Fingers(IdealBody):
    """Fingers between which is something ``wide_m``."""

    def __init__(self, open_m: float, wide_m: float = 0.0) -> None:
        super().__init__()
        self.joints[JOINT.name] = open_m
        self.wide_m = wide_m

    def grip(self, closes: bool) -> GestureStep:
        gesture = GripGesture(GRIPPER, Servo("Hold", GRIPPER, None), closes=closes)
        for _ in range(200):
            step = self.run(gesture, most_s=PERIOD_S)
            self.joints[JOINT.name] = max(self.joints[JOINT.name], self.wide_m)
            if step.outcome is not None:
                break
        return step


def test_fingers_that_are_stopped_hold_something() -> None:
    fingers = Fingers(JOINT.upper, 0.02)
    ended = fingers.grip(closes=True)
    assert (ended.outcome, ended.reason) == ("done", "the fingers stand 20 mm from closed")
    assert ended.commands[0].positions == (JOINT.lower,), "they press on"


def test_fingers_that_close_hold_nothing() -> None:
    ended = Fingers(JOINT.upper).grip(closes=True)
    assert (ended.outcome, ended.reason) == ("failed", "nothing is between the fingers")


def test_closed_fingers_open() -> None:
    fingers = Fingers(JOINT.lower)
    assert fingers.grip(closes=False).outcome == "done"
    assert fingers.joints[JOINT.name] == pytest.approx(JOINT.upper, abs=0.002)


def test_fingers_that_do_not_open_fail() -> None:
    fingers = Fingers(JOINT.lower)
    fingers.stuck = (JOINT.name,)
    ended = fingers.grip(closes=False)
    assert (ended.outcome, ended.reason) == ("failed", "the fingers do not open")


def test_while_another_behavior_commands_the_gripper_nothing_is_concluded() -> None:
    fingers = Fingers(JOINT.upper, JOINT.upper)
    fingers.report("left_gripper", "Release")
    gesture = GripGesture(GRIPPER, Servo("Hold", GRIPPER, None), closes=True)
    assert fingers.run(gesture, most_s=30.0).outcome is None
