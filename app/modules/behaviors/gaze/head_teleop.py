"""HeadTeleop: turning the head by hand, by the same commands and the same lease as driving.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ HeadTeleop  in   operator  TeleopCommand, 20 Hz while held, sticks -1..1; never filtered │
    │             in   joints    JointState, 30 Hz; never filtered                             │
    │             out  command   JointCommand of the group (rad), 25 Hz while held             │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

The sticks give speeds: full stick is the joint's greatest. Positions are commanded, which run ahead of the joints by no
more than ``lead_rad``, so that a head that is held does not run after them later. Released, the joints stop where they
brake to; silence while held is a release after ``timeout_s``, and the guard holds the head without any command.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import Field

from app.link import ActuatorGroup, JointLimits
from app.messages import JointCommand, JointState, TeleopCommand
from app.modules.behaviors.teleop import TELEOPERATION
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings


class HeadTeleopSettings(Settings):
    """Settings of HeadTeleop."""

    group: str = Field("head", min_length=1, description="actuator group of the joints")
    pan: str = Field("pan_joint", min_length=1, description="joint that turns to the left as its position grows")
    tilt: str = Field("tilt_joint", min_length=1, description="joint that turns up as its position grows")
    timeout_s: float = Field(0.25, gt=0, le=1, description="validity of a held command without another")
    period_s: float = Field(0.04, gt=0, le=0.1, description="time between two commands")
    lead_rad: float = Field(0.25, gt=0, le=1, description="greatest lead of commanded positions over measured ones")


def driven_position(position: float, measured: float, rate: float, limits: JointLimits, lead: float) -> float:
    """The commanded position moved by ``rate`` (rad), within ``lead`` (rad) of ``measured`` and within the limits."""
    ahead = min(max(position + rate, measured - lead), measured + lead)
    return min(max(ahead, limits.lower), limits.upper)


class HeadTeleop(Module):
    """Turns the head while an operator holds it."""

    title = "Head by hand"
    desire_classes = (TELEOPERATION,)
    Settings = HeadTeleopSettings
    settings: HeadTeleopSettings

    _group: ActuatorGroup

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.operator = self.input("operator", TeleopCommand, capacity=8, always_open=True)
        self.joints = self.input("joints", JointState, always_open=True)
        self.command = self.output("command", JointCommand)
        self.on(self.operator, self._take)
        self.on(self.joints, self._take_joints)
        self.every(self.settings.period_s, self._beat)
        self._speed = 1.0
        self._measured: Mapping[str, float] = {}
        self._held: TeleopCommand | None = None
        self._goals: dict[str, float] = {}

    async def start(self) -> None:
        """Look up the joints. Raises ModuleFailed for a body without the group or without its joints."""
        body = robot_link(self).description
        if self.settings.group not in body.groups:
            raise ModuleFailed(f"{self.name} moves the group {self.settings.group!r}, which {body.name} does not have")
        self._group = body.groups[self.settings.group]
        names = [joint.name for joint in self._group.joints]
        for name in (self.settings.pan, self.settings.tilt):
            if name not in names:
                raise ModuleFailed(
                    f"{self.name} turns the joint {name!r}, which the {self._group.name} of {body.name} does not have "
                    f"(it has: {', '.join(names)})"
                )

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take ``speed`` (share of the joints' speeds, in ]0, 1]) from the desire; 1 without one."""
        self._speed = float(parameters.get("speed", 1.0))

    async def _take(self, command: TeleopCommand) -> None:
        if command.head_held and all(math.isfinite(axis) for axis in (command.pan, command.tilt)):
            self._held = command
        elif self._held is not None:
            self._let_go()

    async def _take_joints(self, joints: JointState) -> None:
        self._measured = dict(zip(joints.names, joints.positions, strict=True))

    async def _beat(self) -> None:
        held = self._held
        if held is None:
            return
        if self.clock.now() - held.stamp > self.settings.timeout_s:
            self.log.warning("stopped: the head was held, but nothing came from the operator for a while")
            self._let_go()
            return
        rates = {self.settings.pan: held.pan, self.settings.tilt: held.tilt}
        for joint in self._group.joints:
            measured = self._measured.get(joint.name)
            if joint.name in rates and measured is not None:
                stick = max(-1.0, min(1.0, rates[joint.name]))
                step = stick * self._speed * joint.velocity * self.settings.period_s
                position = self._goals.get(joint.name, measured)
                self._goals[joint.name] = driven_position(position, measured, step, joint, self.settings.lead_rad)
        self._publish()

    def _let_go(self) -> None:
        """Command where the joints stop, if they brake now: the last command would carry them on to their goals."""
        held, self._held = self._held, None
        rates = {} if held is None else {self.settings.pan: held.pan, self.settings.tilt: held.tilt}
        for joint in self._group.joints:
            if joint.name in self._goals and joint.name in self._measured:
                speed = self._speed * max(-1.0, min(1.0, rates.get(joint.name, 0.0))) * joint.velocity
                braking = math.copysign(speed**2 / (2 * joint.acceleration), speed)
                goal, here = self._goals[joint.name], self._measured[joint.name]
                # No further than it was commanded already.
                near, far = sorted((here, goal))
                self._goals[joint.name] = min(max(here + braking, near), far)
        self._publish()
        self._goals = {}

    def _publish(self) -> None:
        if self._goals:
            names, positions = tuple(self._goals), tuple(self._goals.values())
            self.command.publish(JointCommand(self.clock.now(), self._group.name, names, positions))
