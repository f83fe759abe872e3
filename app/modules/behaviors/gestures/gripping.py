"""Gripping: closing a gripper until something stops it, and opening it. No clock, no channel."""

from __future__ import annotations

from collections import deque

from app.link import ActuatorGroup
from app.modules.behaviors.gestures.gesture import Gesture, GestureStep, GestureView, Servo, failed

#: A gripper so near (m) to an end of its way is there.
_THERE_M = 0.002
#: A gripper whose positions differ by less (m), for so long (s), stands.
_STANDS_M = 0.003
_STANDS_S = 0.5
#: A gripper that has not come to an end after so long (s) beyond its time has failed.
_LATE_S = 4.0


class GripGesture(Gesture):
    """Closes a gripper's one joint on a thing, or opens it (``closes`` False)."""

    def __init__(self, gripper: ActuatorGroup, servo: Servo, *, closes: bool) -> None:
        self._joint = gripper.joints[0]
        self._servo = servo
        self._closes = closes
        self._ends: float | None = None
        #: Times and positions of the last ``_STANDS_S``, and the one before.
        self._past: deque[tuple[float, float]] = deque()

    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""
        joint, position = self._joint, view.measured[self._joint.name]
        if self._ends is None or not self._servo.drives(view):
            self._ends = view.now + (joint.upper - joint.lower) / joint.velocity + _LATE_S
        goal = joint.lower if self._closes else joint.upper
        command = self._servo.command(view.now, (joint.name,), (goal,))
        if not self._closes and joint.upper - position < _THERE_M:
            return GestureStep((command,), outcome="done")
        if self._closes and self._stands(view.now, position) and self._servo.drives(view):
            open_m = position - joint.lower
            if open_m < _THERE_M:
                return GestureStep((command,), outcome="failed", reason="nothing is between the fingers")
            return GestureStep(
                (command,), outcome="done", reason=f"the fingers stand {1000 * open_m:.0f} mm from closed"
            )
        if view.now > self._ends:
            return failed("the fingers do not come to rest" if self._closes else "the fingers do not open")
        return GestureStep((command,))

    def _stands(self, now: float, position: float) -> bool:
        self._past.append((now, position))
        while len(self._past) > 1 and self._past[1][0] <= now - _STANDS_S:
            self._past.popleft()
        positions = [past for _, past in self._past]
        return self._past[0][0] <= now - _STANDS_S and max(positions) - min(positions) < _STANDS_M
