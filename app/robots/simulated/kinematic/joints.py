"""The joints of a kinematic body: they follow their guards' set-points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from app.link import ActuatorGroup
from app.messages import GroupStatus, JointCommand
from app.robots import joint_guard
from app.robots.simulated.kinematic_servos import KinematicServos


class KinematicJoints:
    """All ``groups`` of joints of a body."""

    def __init__(self, groups: Iterable[ActuatorGroup]) -> None:
        self._groups = {group.name: KinematicServos(group) for group in groups}

    def accept(self, command: JointCommand) -> None:
        """Take a command; one to a group that the body does not have is ignored."""
        if (servos := self._groups.get(command.group)) is not None:
            servos.state = joint_guard.accept(servos.state, servos.group, command)

    def clear_e_stop(self) -> None:
        """Drop all commands from before the stop was cleared."""
        for servos in self._groups.values():
            servos.state = joint_guard.clear_e_stop(servos.state, servos.group)

    def step(self, now: float, seconds: float, e_stop: str | None) -> None:
        """Move for the ``seconds`` until ``now`` (s, robot's clock); ``e_stop``: reason of the latched stop, or
        None."""
        for servos in self._groups.values():
            servos.action = joint_guard.decide(now, servos.state, servos.group, e_stop)
            servos.step(seconds)

    def positions(self) -> Mapping[str, float]:
        """Positions by name (rad, or m where prismatic)."""
        return {
            limits.name: setpoint.position
            for servos in self._groups.values()
            for limits, setpoint in zip(servos.group.joints, servos.state.setpoints, strict=True)
        }

    def status(self, now: float) -> tuple[GroupStatus, ...]:
        """The state of each group."""
        return tuple(
            joint_guard.status(now, servos.state, servos.group, servos.action) for servos in self._groups.values()
        )
