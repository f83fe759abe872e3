"""Wave: waves with a raised hand. Ports as ArmBehavior has them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.modules.behaviors.gestures.arm_behavior import ArmBehavior
from app.modules.behaviors.gestures.gesture import Gesture
from app.modules.behaviors.gestures.gesture_parameters import WAVE, WaveParameters
from app.modules.behaviors.gestures.reaching import SequenceGesture, waving_postures


class Wave(ArmBehavior):
    """Waves with an arm, the right one where both are free."""

    title = "Wave"
    serves = WAVE

    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """Wave with the arm asked for, or with one that no other behavior commands."""
        given = WaveParameters.model_validate(params)
        arms = list(self.arms(given.arm, "right").values())
        view = self.view()
        servos = [self.servo(arm.group, given) for arm in arms]
        free = [pair for pair in zip(arms, servos, strict=True) if pair[1].drives(view)]
        arm, servo = (free or list(zip(arms, servos, strict=True)))[0]
        return SequenceGesture(arm, servo, waving_postures(arm, given.times), f"the {arm.side} arm waved")
