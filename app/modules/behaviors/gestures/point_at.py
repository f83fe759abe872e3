"""PointAt: points at a point with the better arm; beyond ±60° the base turns to it first.

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ PointAt    in, out as PointedBehavior                                                    │
│            out  twist            Twist (rad/s in base_link), 10 Hz while the base turns │
└─────────────────────────────────────────────────────────────────────────────────────────┘
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.messages import Twist
from app.modules.behaviors.gestures.gesture import Gesture, GestureStep
from app.modules.behaviors.gestures.gesture_parameters import POINT_AT, PointAtParameters
from app.modules.behaviors.gestures.pointed_behavior import PointedBehavior
from app.modules.behaviors.gestures.pointing import PointingGesture
from app.modules.stream_module import robot_link
from app.runtime.module import ModuleContext

#: Share of the base's greatest speed: people stand near what is pointed at.
_TURN_SHARE = 0.5


class PointAt(PointedBehavior):
    """Points at a point."""

    title = "Point at"
    serves = POINT_AT

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.twist = self.output("twist", Twist)
        self._turns = False

    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """Point with the arm asked for, or with the better one."""
        given = PointAtParameters.model_validate(params)
        self.take_point(params)
        arms = self.arms(given.arm)
        turns = robot_link(self).description.limits.angular_radps * _TURN_SHARE
        return PointingGesture(
            arms,
            {side: self.servo(arm.group, given) for side, arm in arms.items()},
            hold_s=given.hold_s,
            turn_radps=turns if given.turn and self.twist.wanted else None,
        )

    def give(self, step: GestureStep) -> None:
        """Publish the commands, and how the base turns; one zero after it."""
        super().give(step)
        if step.turn_radps is None:
            self.pause()
        else:
            self._turns = True
            self.twist.publish(Twist(self.clock.now(), 0.0, step.turn_radps))

    def pause(self) -> None:
        """End the base's turn."""
        if self._turns:
            self._turns = False
            self.twist.publish(Twist(self.clock.now(), 0.0, 0.0))

    def last_word(self, port: str) -> Twist | None:
        """A stop of the base."""
        return Twist(self.clock.now(), 0.0, 0.0) if port == self.twist.name and self._turns else None
