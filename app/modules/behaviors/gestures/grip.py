"""Hold and Release: close and open a gripper. Ports as ArmBehavior has them, with the grippers' reports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from app.modules.behaviors.gestures.arm_behavior import ArmBehavior
from app.modules.behaviors.gestures.gesture import Gesture
from app.modules.behaviors.gestures.gesture_parameters import HOLD, RELEASE, GripperParameters
from app.modules.behaviors.gestures.gripping import GripGesture


class _Grip(ArmBehavior):
    closes: ClassVar[bool]

    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """Close or open the gripper asked for."""
        given = GripperParameters.model_validate(params)
        (arm,) = self.arms(given.arm).values()
        if arm.gripper is None:
            raise ValueError(f"the {arm.side} arm has no gripper")
        return GripGesture(arm.gripper, self.servo(arm.gripper, given), closes=self.closes)


class Hold(_Grip):
    """Closes a gripper on what is between its fingers. It stays closed: the guard holds it without commands."""

    title = "Hold"
    serves = HOLD
    closes = True


class Release(_Grip):
    """Opens a gripper."""

    title = "Release"
    serves = RELEASE
    closes = False
