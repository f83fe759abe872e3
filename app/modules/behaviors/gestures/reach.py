"""Reach: brings a hand to a point. Ports as PointedBehavior has them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.modules.behaviors.gestures.gesture import Gesture
from app.modules.behaviors.gestures.gesture_parameters import REACH, ReachParameters
from app.modules.behaviors.gestures.pointed_behavior import PointedBehavior
from app.modules.behaviors.gestures.reaching import ReachGesture


class Reach(PointedBehavior):
    """Reaches for a point with the arm whose shoulder is nearest to it."""

    title = "Reach"
    serves = REACH

    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """Reach with the arm asked for, or with the better one."""
        given = ReachParameters.model_validate(params)
        self.take_point(params)
        arms = self.arms(given.arm)
        return ReachGesture(arms, {side: self.servo(arm.group, given) for side, arm in arms.items()}, given.hold_s)
