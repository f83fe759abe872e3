"""What the arbiters of all actuator groups share: behaviors' commands in, one of them out, exploitation reported."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import partial
from typing import ClassVar, Generic, Self

from pydantic import Field, model_validator

from app.messages import Exploitation
from app.modules.actuation.arbitration import C, Contender, arbitrate, fresh
from app.runtime.module import Module, ModuleContext, Settings


class ArbiterSettings(Settings):
    """Settings of every arbiter."""

    #: Inputs of the arbiter that bring no behavior's commands.
    own_inputs: ClassVar[frozenset[str]] = frozenset()

    behaviors: tuple[Contender, ...] = ()
    max_age_s: float = Field(0.25, gt=0, le=1, description="an older command is out")
    period_s: float = Field(0.1, gt=0, le=0.15, description="arbitration at least this often")

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        ports = [behavior.input for behavior in self.behaviors]
        if len(set(ports)) < len(ports):
            raise ValueError(f"each behavior needs an input of its own, not {', '.join(ports)}")
        if taken := self.own_inputs.intersection(ports):
            raise ValueError(
                f"the input {' and '.join(sorted(taken))} brings no behavior's commands: name it otherwise"
            )
        return self


class GroupArbiter(Module, ABC, Generic[C]):
    """Lets one behavior at a time command an actuator group, and publishes which.

    Arbitration is at each command that arrives and every ``period_s``. A subclass gives the winner's command to the
    link (:meth:`give`).
    """

    settings: ArbiterSettings

    def __init__(self, context: ModuleContext, command_type: type[C], *, capacity: int = 1) -> None:
        super().__init__(context)
        self.exploitation = self.output("exploitation", Exploitation)
        for contender in self.settings.behaviors:
            port = self.input(
                contender.input, command_type, capacity=capacity, always_open=True, moves=not contender.unattended
            )
            self.on(port, partial(self._take, contender.input))
        self.every(self.settings.period_s, self._beat)
        self._commands: dict[str, C] = {}
        self._reported: tuple[str | None, bool] = (None, False)
        self._unattended = {contender.behavior for contender in self.settings.behaviors if contender.unattended}
        #: The behavior whose command is let through now (none where that is unattended), and why it is limited, in
        #: words.
        self.driver: str | None = None
        self.limited = ""

    @abstractmethod
    def usable(self, command: C) -> bool:
        """Whether ``command`` can be given to the group at all; one that cannot counts as none."""

    @abstractmethod
    def give(self, now: float, choice: tuple[str, C] | None) -> None:
        """Give the link the command of the behavior that won, or what there is to give without any."""

    @abstractmethod
    def report(self, now: float) -> Exploitation:
        """What was let through last."""

    def arbitrate(self) -> None:
        """Choose and give now; report if another behavior was chosen, or if a limit begins or ends."""
        if self._arbitrated() != self._reported:
            self._publish()

    def _take(self, port: str, command: C) -> None:
        self._commands[port] = command
        self.arbitrate()

    async def _beat(self) -> None:
        self._arbitrated()
        self._publish()

    def _arbitrated(self) -> tuple[str | None, bool]:
        now = self.clock.now()
        choice = arbitrate(now, self._commands, self.settings.behaviors, self.settings.max_age_s, self.usable)
        self.driver = None if choice is None or choice[0] in self._unattended else choice[0]
        self.give(now, choice)
        return self.driver, bool(self.limited)

    def _publish(self) -> None:
        self._reported = self.driver, bool(self.limited)
        now = self.clock.now()
        report, outdone = self.report(now), self._outdone(now)
        self.exploitation.publish(replace(report, outdone=outdone) if outdone else report)

    def _outdone(self, now: float) -> tuple[str, ...]:
        if self.driver is None:
            return ()
        heard = fresh(now, self._commands, self.settings.behaviors, self.settings.max_age_s, self.usable)
        names = (each.behavior for each in heard if not each.unattended and each.behavior != self.driver)
        return tuple(dict.fromkeys(names))
