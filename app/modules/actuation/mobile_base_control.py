"""MobileBaseControl: which behavior drives the base, within its limits (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ MobileBaseControl  in   one per behavior  Twist (m/s, rad/s in base_link); never filtered│
    │                    out  exploitation      Exploitation, 10 Hz and when the driver changes│
    │                    out  status            LinkStatus, 20 Hz, as the guard reports        │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At 10 Hz and with each command that arrives: the highest priority among the behaviors with a fresh command drives; its
twist is clamped to the body's speeds and approached with the body's accelerations, then given to the robot link. When
nobody commands, zero is sent a few times, then nothing. ``exploitation`` tells attention whose command was let through.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.link import RobotLink
from app.messages import Exploitation, LinkStatus, Twist
from app.modules.actuation.arbitration import Contender, approach, arbitrate, clamped
from app.modules.body import attach, robot_link
from app.runtime.module import Module, ModuleContext, Settings

#: So many zeros are sent after the last command, in case one is lost on the way to the motors.
PARTING_ZEROS = 3


class ContenderSettings(BaseModel):
    """One behavior that may drive."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    input: str = Field(min_length=1, description="name of the input port its twists come in by")
    behavior: str = Field(min_length=1, description="name of the behavior, as exploitation reports it")
    priority: int = Field(description="the highest priority among those with a fresh command drives")


class MobileBaseControlSettings(Settings):
    """Settings of MobileBaseControl."""

    behaviors: tuple[ContenderSettings, ...] = (ContenderSettings(input="teleop", behavior="Teleop", priority=1),)
    max_age_s: float = Field(0.25, gt=0, le=1, description="an older command is out")
    period_s: float = Field(0.1, gt=0, le=0.15, description="arbitration at least this often")

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        ports = [behavior.input for behavior in self.behaviors]
        if len(set(ports)) < len(ports):
            raise ValueError(f"each behavior needs an input of its own, not {', '.join(ports)}")
        return self


class MobileBaseControl(Module):
    """Lets one behavior at a time drive, and tells which."""

    title = "Mobile base control"
    streams = MappingProxyType({"status": "status"})
    Settings = MobileBaseControlSettings
    settings: MobileBaseControlSettings

    _link: RobotLink

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.exploitation = self.output("exploitation", Exploitation)
        self.status = self.output("status", LinkStatus)
        self._contenders = tuple(Contender(b.input, b.behavior, b.priority) for b in self.settings.behaviors)
        for contender in self._contenders:
            port = self.input(contender.port, Twist, always_open=True)
            self.on(port, partial(self._take, contender.port))
        self.every(self.settings.period_s, self._beat)
        self._commands: dict[str, Twist] = {}
        self._sent = Twist(0.0, 0.0, 0.0)
        self._driver: str | None = None
        self._zeros_left = PARTING_ZEROS
        self._release: Callable[[], None] | None = None

    async def start(self) -> None:
        """Take hold of the body. Raises ModuleFailed for a body without status."""
        self._release = attach(self, "status", LinkStatus, self.status.publish)
        self._link = robot_link(self)

    async def stop(self) -> None:
        """Leave the wheels commanded to zero."""
        if self._release is not None:
            self._release()
            self._link.command(Twist(self.clock.now(), 0.0, 0.0))

    async def _take(self, port: str, command: Twist) -> None:
        self._commands[port] = command
        before = self._driver
        self._drive()
        if self._driver != before:
            self._report()

    async def _beat(self) -> None:
        self._drive()
        self._report()

    def _drive(self) -> None:
        now = self.clock.now()
        limits = self._link.description.limits
        choice = arbitrate(now, self._commands, self._contenders, self.settings.max_age_s)
        if choice is None:
            self._driver = None
            # The stamp stays that of the last command: the first one after a rest gets a whole period to speed up.
            self._sent = Twist(self._sent.stamp, 0.0, 0.0)
            if self._zeros_left == 0:
                return
            self._zeros_left -= 1
        else:
            self._driver, wanted = choice
            target = clamped(Twist(now, wanted.linear_mps, wanted.angular_radps), limits)
            self._sent = approach(self._sent, target, limits, self.settings.period_s)
            self._zeros_left = PARTING_ZEROS
        self._link.command(replace(self._sent, stamp=now))

    def _report(self) -> None:
        now = self.clock.now()
        self.exploitation.publish(Exploitation(now, self._driver, replace(self._sent, stamp=now)))
