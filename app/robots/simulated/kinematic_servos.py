"""Joints without physics: they are where their guard's set-points are."""

from __future__ import annotations

from app.link import ActuatorGroup
from app.robots import joint_guard
from app.robots.joint_guard import JointAction, JointGuardState


class KinematicServos:
    """The joints of ``group``, at 0 or the position within their limits that is nearest to it.

    Set-points move every ``period_s`` (s) at most: their profile is exact for steps of any length.
    """

    def __init__(self, group: ActuatorGroup, period_s: float = 0.01) -> None:
        self.group = group
        self.state: JointGuardState = joint_guard.at_rest(group, (0.0,) * len(group.joints))
        self.action: JointAction = joint_guard.decide(0.0, self.state, group, None)
        self._period_s = period_s
        self._elapsed_s = 0.0

    def step(self, dt_s: float) -> None:
        """Move the set-points, of several steps at once."""
        self._elapsed_s += dt_s
        if self._elapsed_s + 1e-9 >= self._period_s:
            positions = tuple(setpoint.position for setpoint in self.state.setpoints)
            self.state = joint_guard.step(self.state, self.action, self.group, positions, self._elapsed_s)
            self._elapsed_s = 0.0
