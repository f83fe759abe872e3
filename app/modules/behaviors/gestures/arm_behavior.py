"""The module that all behaviors of the arms are: a desire in, its gesture's commands out.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ a gesture  in   joints           JointState, 30 Hz; never filtered                      │
    │            in   left, right      Exploitation of the groups that it commands            │
    │            out  command          JointCommand, 10 Hz while there is a desire            │
    │            out  accomplishments  Accomplishment, when the gesture has ended             │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

The strongest desire of the class is served while attention has the output ``command`` open. A desire whose parameters
change begins again. Commands end with the gesture: the guard holds the arm until another behavior commands it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from typing import Any, ClassVar

from pydantic import Field

from app.attention.desires import Desire, DesireClass
from app.attention.workspace import IntentionWorkspace
from app.base.errors import ConfigError
from app.link import ActuatorGroup
from app.messages import Exploitation, JointCommand, JointState
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.gestures.arm_kinematics import OtherArm, OutOfReach
from app.modules.behaviors.gestures.arms import Arm, load_arms
from app.modules.behaviors.gestures.gesture import Gesture, GestureStep, GestureView, Servo
from app.modules.behaviors.gestures.impedance import StiffnessParameters, impedance
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext, Settings

#: Greatest age (s) of an arbiter's report.
_FRESH_S = 0.5


class ArmBehaviorSettings(Settings):
    """Settings of the behaviors of the arms."""

    period_s: float = Field(0.1, gt=0, le=0.2, description="time between two commands")


class ArmBehavior(Module, ABC):
    """Serves the desires of :attr:`serves` by a gesture each."""

    #: The class of the desires.
    serves: ClassVar[DesireClass]
    Settings = ArmBehaviorSettings
    settings: ArmBehaviorSettings

    _workspace: IntentionWorkspace
    _arms: Mapping[str, Arm]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "serves" in cls.__dict__:
            cls.desire_classes = (cls.serves,)

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.joints = self.input("joints", JointState, always_open=True, rests=True)
        self.on(self.joints, self._take_joints)
        for side in ("left", "right"):
            self.on(self.input(side, Exploitation, wants="never", rests=True), self._take_report)
        self.command = self.output("command", JointCommand)
        self.accomplishments = AccomplishmentReporter(self, self.serves.name)
        self.every(self.settings.period_s, self._beat)
        self._measured: Mapping[str, float] = {}
        self._reports: dict[str, Exploitation] = {}
        #: The desire that is served, its gesture, and None in its place once that has ended.
        self._desire: Desire | None = None
        self._gesture: Gesture | None = None
        self._problem = ""

    async def start(self) -> None:
        """Read the body's arms. Raises ModuleFailed for a body without arms, or with arms of another kind."""
        self._workspace = self.service(IntentionWorkspace)
        body = robot_link(self).description
        if not body.arms:
            raise ModuleFailed(f"{self.name} moves arms, and {body.name} has none: name them under `arms` of its file")
        try:
            self._arms = await self.compute(load_arms, body)
        except (ConfigError, OtherArm, KeyError) as failure:
            raise ModuleFailed(f"{self.name} cannot move the arms of {body.name}: {failure.args[0]}") from None

    def cautions(self) -> tuple[Caution, ...]:
        """A warning where nothing says that a gesture has ended."""
        return self.accomplishments.cautions()

    @abstractmethod
    def make_gesture(self, params: Mapping[str, Any]) -> Gesture:
        """The gesture for a desire's ``params``. Raises ValueError with the reason why there is none."""

    def view(self) -> GestureView:
        """What the gesture sees now."""
        now = self.clock.now()
        fresh = {group: report for group, report in self._reports.items() if now - report.stamp <= _FRESH_S}
        return GestureView(now, self._measured, fresh)

    def give(self, step: GestureStep) -> None:
        """Publish the commands of ``step``."""
        for command in step.commands:
            self.command.publish(command)

    def pause(self) -> None:
        """Attention has closed the output, or there is no desire."""

    def arms(self, choice: str, *first: str) -> dict[str, Arm]:
        """The arms that ``choice`` (``left``, ``right``, else all) names, those of the sides ``first`` first. Raises
        ValueError for one that the body does not have."""
        if choice in ("left", "right") and choice not in self._arms:
            raise ValueError(f"there is no {choice} arm")
        sides: Collection[str] = [choice] if choice in ("left", "right") else [*first, *self._arms]
        return {side: self._arms[side] for side in sides if side in self._arms}

    def servo(self, group: ActuatorGroup, wanted: StiffnessParameters) -> Servo:
        """How the gesture commands ``group``. Raises ValueError for a stiffness that the group does not take."""
        return Servo(self.name, group, impedance(group, wanted))

    async def _take_joints(self, joints: JointState) -> None:
        self._measured = dict(zip(joints.names, joints.positions, strict=True))

    async def _take_report(self, report: Exploitation) -> None:
        self._reports[report.group] = report

    async def _beat(self) -> None:
        desire = self._workspace.wanted(self.serves.name) if self.command.wanted else None
        if desire is None:
            self._desire = self._gesture = None
            self._say("")
            self.pause()
            return
        if self._desire is None or (self._desire.id, self._desire.params) != (desire.id, desire.params):
            self._desire = desire
            try:
                self._gesture = self.make_gesture(desire.params)
            except (ValueError, OutOfReach) as failure:
                self._end(GestureStep(outcome="failed", reason=str(failure)))
        if self._gesture is None or not self._measured:
            return
        step = await self.compute(self._gesture.step, self.view())
        self.give(step)
        if step.outcome is not None:
            self._end(step)
        else:
            self._say(step.reason)

    def _end(self, step: GestureStep) -> None:
        assert step.outcome is not None
        assert self._desire is not None
        self._gesture = None
        self.pause()
        if step.outcome == "failed":
            self._say(step.reason)
        desire_id = self._desire.id
        self.accomplishments.report(step.outcome, step.reason, lambda desire: desire.id == desire_id)

    def _say(self, problem: str) -> None:
        if problem != self._problem:
            self._problem = problem
            if problem:
                self.log.info("%s", problem)
