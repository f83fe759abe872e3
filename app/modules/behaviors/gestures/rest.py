"""Rest: lets the arms hang, or makes them free to be led. Ports as ArmBehavior has them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.modules.behaviors.gestures.arm_behavior import ArmBehavior
from app.modules.behaviors.gestures.gesture import Gesture
from app.modules.behaviors.gestures.gesture_parameters import REST, RestParameters
from app.modules.behaviors.gestures.reaching import RestGesture


class Rest(ArmBehavior):
    """Brings arms to their posture at rest."""

    title = "Rest"
    serves = REST

    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """Rest one arm, or both."""
        given = RestParameters.model_validate(params)
        arms = self.arms(given.arm)
        return RestGesture(arms, {side: self.servo(arm.group, given) for side, arm in arms.items()}, given.hold_s)
