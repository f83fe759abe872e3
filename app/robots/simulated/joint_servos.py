"""The servos of the body's actuator groups: the joint guard's set-points and stiffness, written into the physics.

Kinematic groups have none: their joints are where the set-points are.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np

from app.link import ActuatorGroup, SafeAction
from app.messages import GroupStatus, JointCommand
from app.robots import joint_guard
from app.robots.joint_guard import JointAction, JointGuardState, JointSetpoint
from app.robots.simulated.body import PREFIX, RobotSimulation
from app.robots.simulated.kinematic_servos import KinematicServos


class JointServos:
    """Guards and moves the joints of ``groups``; all others keep their place."""

    def __init__(self, physics: RobotSimulation, groups: Iterable[ActuatorGroup]) -> None:
        self._physics = physics
        actuators = physics.config.actuators
        self._groups: dict[str, _GroupServos | KinematicServos] = {
            group.name: KinematicServos(group) if actuators[group.name].kinematic else _GroupServos(physics, group)
            for group in groups
        }
        #: Those that have forces, and those that are outside the physics.
        self._powered = [servos for servos in self._groups.values() if isinstance(servos, _GroupServos)]
        self._kinematic = [servos for servos in self._groups.values() if isinstance(servos, KinematicServos)]
        watched = [limits for servos in self._powered for limits in servos.group.joints]
        self._joints = physics.joint_numbers(limits.name for limits in watched)
        self._limits = np.array([limits.contact for limits in watched])
        self._felt_s = self._stepped_s = physics.time_s

    def accept(self, command: JointCommand) -> None:
        """Take a command; one to a group that the body does not have is ignored."""
        if command.group in self._groups:
            servos = self._groups[command.group]
            servos.state = joint_guard.accept(servos.state, servos.group, command)

    def clear_e_stop(self) -> None:
        """Drop all commands from before the stop was cleared."""
        for servos in self._groups.values():
            servos.state = joint_guard.clear_e_stop(servos.state, servos.group)

    def decide(self, now: float, e_stop: str | None) -> None:
        """Run every group's guard at ``now`` (s, robot's clock); ``e_stop`` as :func:`joint_guard.decide` has it."""
        self._feel(now)
        for servos in self._groups.values():
            servos.action = joint_guard.decide(now, servos.state, servos.group, e_stop)

    def step(self) -> None:
        """Move every set-point by the simulated time since the last call."""
        dt_s, self._stepped_s = self._physics.time_s - self._stepped_s, self._physics.time_s
        for servos in self._groups.values():
            servos.step(dt_s)

    def _feel(self, now: float) -> None:
        """Give the groups what their joints have felt from outside since the last time."""
        dt_s, self._felt_s = self._physics.time_s - self._felt_s, self._physics.time_s
        external = self._physics.external_efforts()[self._joints]
        if not (np.abs(external) > self._limits).any() and not any(s.state.pressed_s for s in self._powered):
            return
        felt = iter(external.tolist())
        for servos in self._powered:
            own = tuple(itertools.islice(felt, len(servos.group.joints)))
            servos.state = joint_guard.feel(now, servos.state, servos.group, own, dt_s)

    def setpoints(self) -> tuple[float, ...]:
        """The set-points (rad) of all groups' joints, in the order of the groups; NaN for a joint that yields."""
        return tuple(
            setpoint.position if setpoint.stiffness > 0 else math.nan
            for servos in self._groups.values()
            for setpoint in servos.state.setpoints
        )

    def kinematic_positions(self) -> dict[str, float]:
        """Positions (rad, m) by name of the joints that are outside the physics."""
        return {
            joint.name: setpoint.position
            for servos in self._kinematic
            for joint, setpoint in zip(servos.group.joints, servos.state.setpoints, strict=True)
        }

    def status(self, now: float) -> tuple[GroupStatus, ...]:
        """The state of each group."""
        return tuple(
            joint_guard.status(now, servos.state, servos.group, servos.action) for servos in self._groups.values()
        )


class _GroupServos:
    """One group: its guard's state, and its servos in the physics."""

    def __init__(self, physics: RobotSimulation, group: ActuatorGroup) -> None:
        model = physics.model
        self.group = group
        self._physics = physics
        self._actuators = [int(model.actuator(PREFIX + joint.name).id) for joint in group.joints]
        self._addresses = [int(model.joint(PREFIX + joint.name).qposadr[0]) for joint in group.joints]
        #: Gains of the servos that the body comes with (N m/rad, N m s/rad): those of a group that is not compliant.
        self._gains = [
            (float(model.actuator_gainprm[u, 0]), -float(model.actuator_biasprm[u, 2])) for u in self._actuators
        ]
        self._applied: tuple[JointSetpoint, ...] = ()
        #: The state and the safe action that a step left as they were.
        self._settled: tuple[JointGuardState, SafeAction | None] | None = None
        self.state: JointGuardState = joint_guard.at_rest(group, self._measured())
        self.action: JointAction = joint_guard.decide(0.0, self.state, group, None)

    def step(self, dt_s: float) -> None:
        """Move the set-points, and give them to the servos."""
        if self._settled is not None and self._settled[0] is self.state and self._settled[1] is self.action.safe:
            return
        state = joint_guard.step(self.state, self.action, self.group, self._measured(), dt_s)
        if state is self.state and self.action.safe is not SafeAction.YIELD:
            self._settled = state, self.action.safe
        self.state = state
        if self.state.setpoints is self._applied:
            return
        control = self._physics.data.ctrl
        for number, setpoint in enumerate(self.state.setpoints):
            control[self._actuators[number]] = setpoint.position
            before = self._applied[number] if self._applied else None
            if before is None or (before.stiffness, before.damping) != (setpoint.stiffness, setpoint.damping):
                self._set_gains(number, setpoint)
        self._applied = self.state.setpoints

    def _measured(self) -> tuple[float, ...]:
        qpos = self._physics.data.qpos
        return tuple(qpos.item(address) for address in self._addresses)

    def _set_gains(self, number: int, setpoint: JointSetpoint) -> None:
        model, actuator = self._physics.model, self._actuators[number]
        stiffness, damping = self._gains[number]
        if self.group.compliant:
            stiffness, damping = setpoint.stiffness, setpoint.damping
        elif setpoint.stiffness == 0:
            stiffness = 0.0
        # MuJoCo's position servo: torque = K (ctrl - q) - D dq/dt
        model.actuator_gainprm[actuator, 0] = stiffness
        model.actuator_biasprm[actuator, 1] = -stiffness
        model.actuator_biasprm[actuator, 2] = -damping
