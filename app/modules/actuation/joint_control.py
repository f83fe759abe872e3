"""JointControl: which behavior commands a group of joints (the head, an arm), as MobileBaseControl for the wheels.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ JointControl  in   one per behavior  JointCommand (rad) of the group; never filtered    │
    │               in   joints            JointState, 30 Hz; never filtered; needed by an arm│
    │               out  exploitation      Exploitation, 10 Hz and when the behavior changes  │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At 10 Hz and with each command that arrives: the command of the highest priority among the behaviors with a fresh one is
given to the link, whose guard keeps the joints within their positions, speeds and accelerations. Without a fresh
command nothing is given, and the guard takes the group's safe action. Each group has a module of this class of its own,
by the setting ``group``. A behavior may command several groups on one channel: commands of other groups are ignored.

In front of an arm (``arms`` in the body's file) is a check (``arm_check.py``): a set-point that is out of reach, or on
whose way the arm would touch the rest of the body, is refused. The arm is held then; ``exploitation`` has the reason.
"""

from __future__ import annotations

from dataclasses import replace

from pydantic import Field

from app.base.collision_shapes import load_collision_shapes
from app.base.errors import ConfigError
from app.base.kinematic_model import load_model
from app.base.self_collision import SelfCollision
from app.link import ActuatorGroup, RobotDescription
from app.messages import Exploitation, JointCommand, JointState, Twist
from app.modules.actuation.arbitration import joints_are_finite
from app.modules.actuation.arm_check import ArmCheck
from app.modules.actuation.group_arbiter import ArbiterSettings, GroupArbiter
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, ModuleContext


class JointControlSettings(ArbiterSettings):
    """Settings of JointControl."""

    own_inputs = frozenset({"joints"})

    group: str = Field(min_length=1, description="the actuator group, as the body's file names it")
    arm_check: bool = Field(True, description="of an arm: refuse what it cannot reach, and ways that touch the body")


class JointControl(GroupArbiter[JointCommand]):
    """Lets one behavior at a time command a group of joints, and publishes which."""

    title = "Joint control"
    Settings = JointControlSettings
    settings: JointControlSettings

    def __init__(self, context: ModuleContext) -> None:
        # A behavior that commands both arms publishes two commands at once.
        super().__init__(context, JointCommand, capacity=8)
        self._joints = self.input("joints", JointState, always_open=True)
        self.on(self._joints, self._take_joints)
        self._misdirected: set[str] = set()
        self._check: ArmCheck | None = None

    def check_wiring(self) -> None:
        """Raises ModuleFailed where the body has no such group, and where an arm cannot be checked."""
        body = robot_link(self).description
        if self.settings.group not in body.groups:
            groups = ", ".join(sorted(body.groups)) or "none"
            raise ModuleFailed(
                f"{self.name} commands the actuator group {self.settings.group!r}, which {body.name} does not have (it "
                f"has: {groups}); describe it under `actuators` of the body's file, or take {self.name} out"
            )
        if self._is_checked(body) and not self._joints.connected:
            raise ModuleFailed(
                f"{self.name} has no input joints, and {self.settings.group} is an arm: without its positions nothing "
                "keeps it from hitting the body; wire them (joints: the joints' channel), or say `arm_check: false`"
            )

    def cautions(self) -> tuple[Caution, ...]:
        """A warning where an arm is not checked."""
        body = robot_link(self).description
        if self.settings.arm_check or not self._is_arm(body):
            return ()
        text = f"{self.settings.group} runs with arm_check switched off: nothing keeps it from hitting the robot's body"
        return (Caution("No check of an arm", text),)

    async def start(self) -> None:
        """Read the arm's shapes. Raises ModuleFailed for a model whose collision shapes cannot be read."""
        body = robot_link(self).description
        if self._is_checked(body):
            try:
                self._check = await self.compute(_arm_check, body, body.groups[self.settings.group])
            except ConfigError as failure:
                raise ModuleFailed(f"{failure}; without shapes, say `arm_check: false` of {self.name}") from None

    def usable(self, command: JointCommand) -> bool:
        """Whether its numbers are finite."""
        return joints_are_finite(command)

    def _take(self, port: str, command: JointCommand) -> None:
        if command.group == self.settings.group:
            super()._take(port, command)
        elif command.group not in robot_link(self).description.groups and port not in self._misdirected:
            self._misdirected.add(port)
            self.log.warning("%s brings commands of the group %s; they are ignored", port, command.group)

    def give(self, now: float, choice: tuple[str, JointCommand] | None) -> None:
        """Pass the command on, or what the arm's check has in its stead; nothing without one: the guard has the last
        word."""
        self.limited = ""
        if self._check is None:
            command = None if choice is None else choice[1]
        elif choice is None:
            self._check.release()
            command = None
        else:
            command, self.limited = self._check.judge(replace(choice[1], stamp=now))
        if command is not None:
            robot_link(self).command(replace(command, stamp=now))

    def report(self, now: float) -> Exploitation:
        """Which behavior's command was let through, and why it was refused."""
        return Exploitation(now, self.driver, Twist(now, 0.0, 0.0), self.limited, group=self.settings.group)

    def _take_joints(self, joints: JointState) -> None:
        if self._check is not None:
            self._check.take(joints)
            if self.driver is not None and self._check.moving:
                # What comes in the arm's way must not wait for the next period.
                self.arbitrate()

    def _is_arm(self, body: RobotDescription) -> bool:
        return any(arm.group == self.settings.group for arm in body.arms.values())

    def _is_checked(self, body: RobotDescription) -> bool:
        return self.settings.arm_check and self._is_arm(body)


def _arm_check(body: RobotDescription, group: ActuatorGroup) -> ArmCheck:
    """The check of ``group``; the joints of all groups move what an arm can touch. Raises ConfigError."""
    shapes = load_collision_shapes(body.model_path)
    collision = SelfCollision(load_model(body.model_path), shapes, [joint.name for joint in group.joints])
    return ArmCheck(group, collision, [joint.name for each in body.groups.values() for joint in each.joints])
