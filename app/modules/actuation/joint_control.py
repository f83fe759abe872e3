"""JointControl: which behavior commands a group of joints (the head, an arm), as MobileBaseControl for the wheels.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ JointControl  in   one per behavior  JointCommand (rad) of the group; never filtered    │
    │               out  exploitation      Exploitation, 10 Hz and when the behavior changes  │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At 10 Hz and with each command that arrives: the command of the highest priority among the behaviors with a fresh one is
given to the link, whose guard keeps the joints within their positions, speeds and accelerations. Without a fresh
command nothing is given, and the guard takes the group's safe action. Each group has a module of this class of its own,
by the setting ``group``.
"""

from __future__ import annotations

from dataclasses import replace

from pydantic import Field

from app.messages import Exploitation, JointCommand, Twist
from app.modules.actuation.arbitration import joints_are_finite
from app.modules.actuation.group_arbiter import ArbiterSettings, GroupArbiter
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import ModuleContext


class JointControlSettings(ArbiterSettings):
    """Settings of JointControl."""

    group: str = Field(min_length=1, description="the actuator group, as the body's file names it")


class JointControl(GroupArbiter[JointCommand]):
    """Lets one behavior at a time command a group of joints, and publishes which."""

    title = "Joint control"
    Settings = JointControlSettings
    settings: JointControlSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context, JointCommand)
        self._misdirected: set[str] = set()

    def check_wiring(self) -> None:
        """Raises ModuleFailed where the body has no such group."""
        body = robot_link(self).description
        if self.settings.group not in body.groups:
            groups = ", ".join(sorted(body.groups)) or "none"
            raise ModuleFailed(
                f"{self.name} commands the actuator group {self.settings.group!r}, which {body.name} does not have (it "
                f"has: {groups}); describe it under `actuators` of the body's file, or take {self.name} out"
            )

    def usable(self, command: JointCommand) -> bool:
        """Whether its numbers are finite."""
        return joints_are_finite(command)

    def _take(self, port: str, command: JointCommand) -> None:
        if command.group == self.settings.group:
            super()._take(port, command)
        elif port not in self._misdirected:
            self._misdirected.add(port)
            self.log.warning("%s brings commands of the group %s; they are ignored", port, command.group)

    def give(self, now: float, choice: tuple[str, JointCommand] | None) -> None:
        """Pass the command on; nothing without one: the guard has the last word."""
        if choice is not None:
            robot_link(self).command(replace(choice[1], stamp=now))

    def report(self, now: float) -> Exploitation:
        """Which behavior's command was let through."""
        return Exploitation(now, self.driver, Twist(now, 0.0, 0.0), group=self.settings.group)
