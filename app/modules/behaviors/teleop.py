"""Teleop: manual driving by an operator (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Teleop    in   operator  TeleopCommand, 20 Hz while held, sticks -1..1; never filtered   │
    │           out  twist     Twist, with each command (m/s, rad/s in base_link)              │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

    v = speed · (stick_linear · v_max, stick_lateral · v_side)        ω = speed · stick_angular · ω_max

``speed`` is the parameter of the desire Teleoperation; v_max, v_side and ω_max are the body's limits (v_side is 0 for a
base that cannot move sideways). The velocity v is shortened into both limits as one vector. Only while the dead-man
is held: its release gives zero at once, silence while held gives zero after ``timeout_s``, and one zero is published
when attention closes the output.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.messages import TeleopCommand, Twist
from app.modules.behaviors.drive_gate import Decision, DriveGate
from app.modules.stream_module import robot_link
from app.runtime.module import Module, ModuleContext, Settings


class TeleopSettings(Settings):
    """Settings of Teleop: two periods whose sum bounds the time from an operator's last command to the stop."""

    timeout_s: float = Field(0.25, gt=0, le=1, description="validity of a held command without another, s")
    period_s: float = Field(0.025, gt=0, le=0.1, description="how often silence is looked for")


class TeleoperationParameters(BaseModel, extra="forbid", title="Drive by hand"):
    speed: float = Field(
        1.0,
        gt=0,
        le=1,
        title="Speed",
        description="Share of the robot's greatest speeds that full stick gives, 0 to 1.",
    )


TELEOPERATION = DesireClass(
    name="Teleoperation",
    title="Drive by hand",
    description="Drive the base by an operator's commands while the dead-man is held.",
    parameters=TeleoperationParameters,
)


class Teleop(Module):
    title = "Teleop"
    desire_classes = (TELEOPERATION,)
    Settings = TeleopSettings
    settings: TeleopSettings

    _gate: DriveGate

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        # Capacity for a burst: a release must neither displace other commands nor be displaced.
        self.operator = self.input("operator", TeleopCommand, capacity=8, always_open=True)
        self.twist = self.output("twist", Twist)
        self._speed = 1.0
        self._refusing = False
        self.on(self.operator, self._take)
        self.every(self.settings.period_s, self._beat)

    async def start(self) -> None:
        self._gate = DriveGate(robot_link(self).description.limits, self.settings.timeout_s)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take ``speed`` (share of the limits, in ]0, 1]) from the intention; 1 without one."""
        self._speed = float(parameters.get("speed", 1.0))

    def last_word(self, port: str) -> Twist | None:
        return Twist(self.clock.now(), 0.0, 0.0)

    async def _take(self, command: TeleopCommand) -> None:
        decision = self._gate.take(command, self._speed)
        if decision.problem and not self._refusing:
            self.log.warning("%s", decision.problem)
        self._refusing = bool(decision.problem)
        self._publish(decision)

    async def _beat(self) -> None:
        decision = self._gate.beat(self.clock.now())
        if decision.problem:
            self.log.warning("%s", decision.problem)
        self._publish(decision)

    def _publish(self, decision: Decision) -> None:
        if decision.twist is not None:
            self.twist.publish(decision.twist)
