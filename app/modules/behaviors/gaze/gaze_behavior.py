"""What all behaviors that look at something share: a body's eye, its joints, and a command for them ten times a second.

    ┌───────────────────────────────────────────────────────────────────────────────────────────┐
    │ GazeBehavior  in   joints           JointState, 30 Hz; never filtered                     │
    │               in   odometry         Odometry, X_OB in odom; never filtered                │
    │               out  command          JointCommand of the group (rad), 10 Hz while it looks │
    │               out  accomplishments  Accomplishment of the desire                          │
    └───────────────────────────────────────────────────────────────────────────────────────────┘

A subclass says which point is looked at (:meth:`GazeBehavior.look`). Where the joints cannot reach it, the head looks
as near to it as they can. Without a point nothing is commanded, and the head is left to behaviors of lower priority.
A desire is done once the eye looks at its point, and has failed for the time being while that is out of reach.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.kinematic_model import KinematicModel, load_model
from app.base.pose_buffer import PoseBuffer
from app.link import ActuatorGroup
from app.messages import Accomplished, JointCommand, JointState, Odometry
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.gaze.gaze_kinematics import Gaze, aim, gaze_error
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext, Settings

G = TypeVar("G", bound=BaseModel)

#: Up to this angle (rad) beside the optical axis the point is looked at.
_LOOKED_AT_RAD = math.radians(2)
#: Percepts are placed with poses as old as this (s).
_POSES_S = 3.0


class GazeSettings(Settings):
    """Settings of every behavior that looks at something."""

    group: str = Field("head", min_length=1, description="actuator group that moves the eye")
    eye: str = Field(
        min_length=1, description="optical frame of the camera that looks (z forward), a link of the model"
    )
    period_s: float = Field(0.1, gt=0, le=0.2, description="time between two commands")


@dataclass(frozen=True, slots=True)
class Look:
    """Where to look: the point ``p_BP`` (3,) m in ``base_link`` now, or None with the ``reason`` in words ("": none
    was asked for). ``as_near``: a point out of reach is no problem but as expected, and looking there accomplishes
    nothing. ``in_front``: it never passes behind the robot, so that the head need not be tried the other way round.
    ``outcome``: what becomes of the desire without a point, for that reason; None: nothing yet."""

    p_BP: NDArray[np.float64] | None
    reason: str = ""
    as_near: bool = False
    in_front: bool = False
    outcome: Accomplished | None = None


class GazeBehavior(Module, ABC, Generic[G]):
    """Looks at a point with the joints of a group; ``G``: the parameters of its desire class."""

    desire_class: ClassVar[DesireClass]
    Settings = GazeSettings
    settings: GazeSettings

    _model: KinematicModel
    _group: ActuatorGroup

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.joints = self.input("joints", JointState, always_open=True, rests=True)
        self.odometry = self.input("odometry", Odometry, capacity=50, always_open=True, rests=True)
        self.command = self.output("command", JointCommand)
        self.on(self.joints, self._take_joints)
        self.every(self.settings.period_s, self._beat)
        #: Poses X_OB of the last seconds, and the newest.
        self.poses = PoseBuffer(span_s=_POSES_S, tolerance_s=0.0)
        self.X_OB: Pose2 | None = None
        self._measured: Mapping[str, float] = {}
        self._aimed: Mapping[str, float] = {}
        self._problem = ""
        self._accomplishments = AccomplishmentReporter(self, self.desire_class.name)
        #: The parameters of the desire that is served; None without one, and of a class that takes none.
        self.given: G | None = None

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "desire_class" in cls.__dict__:
            cls.desire_classes = (cls.desire_class,)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the desire's parameters; without any there is no desire."""
        model: Any = self.desire_class.parameters
        known = {key: parameters[key] for key in model.model_fields if key in parameters}
        given = model.model_validate(known) if known else None
        if given != self.given:
            self.given = given
            self.rest()

    def cautions(self) -> tuple[Caution, ...]:
        """Those of its reports."""
        return self._accomplishments.cautions()

    async def start(self) -> None:
        """Read the body's model. Raises ModuleFailed for a body without the group or the eye."""
        body = robot_link(self).description
        if self.settings.group not in body.groups:
            raise ModuleFailed(f"{self.name} moves the group {self.settings.group!r}, which {body.name} does not have")
        self._group = body.groups[self.settings.group]
        try:
            self._model = await self.compute(load_model, body.model_path)
            self._model.pose(self.settings.eye)
        except ConfigError as failure:
            raise ModuleFailed(str(failure)) from None
        except KeyError as unknown:
            raise ModuleFailed(f"{self.name} cannot look by {self.settings.eye!r}: {unknown.args[0]}") from None

    @abstractmethod
    def look(self, now: float) -> Look:
        """Where to look at ``now`` (robot's clock); called every ``period_s`` while attention lets it look."""

    def rest(self) -> None:
        """Attention has closed the output, or another desire is served: what was followed is dropped."""

    @property
    def p_BE(self) -> NDArray[np.float64]:
        """The eye (3,) m in ``base_link``, with the joints as measured last."""
        return self._model.pose(self.settings.eye, self._measured).translation

    @property
    def aim_error_rad(self) -> float:
        """How far the joint that is furthest from its last commanded position still is; infinite before one."""
        if not self._aimed:
            return math.inf
        return max(abs(self._measured.get(name, math.inf) - position) for name, position in self._aimed.items())

    async def _take_joints(self, joints: JointState) -> None:
        self._measured = dict(zip(joints.names, joints.positions, strict=True))

    def _gather_odometry(self) -> None:
        # Ten times a second together, not one by one: that costs next to nothing while it rests.
        while self.odometry.connected and self.odometry.subscription.waiting:
            odometry = self.odometry.subscription.receive_nowait()
            self.poses.add(odometry.stamp, odometry.X_OB)
            self.X_OB = odometry.X_OB

    async def _beat(self) -> None:
        self._gather_odometry()
        if not self.command.wanted:
            self._aimed = {}
            self.rest()
            self._say("")
            return
        given, measured = self.given, self._measured
        look = self.look(self.clock.now())
        if look.p_BP is None:
            self._aimed = {}
            self._say(look.reason)
            self._report(look.outcome, look.reason, given)
            return
        gaze, error_rad = await self.compute(self._aim, look.p_BP, measured, self._aimed, look.in_front)
        self._aimed = gaze.positions
        out_of_reach = gaze.error_rad > _LOOKED_AT_RAD and not look.as_near
        problem = f"the point is out of the {self._group.name}'s reach" if out_of_reach else ""
        self._say(problem or look.reason)
        names, positions = tuple(gaze.positions), tuple(gaze.positions.values())
        self.command.publish(JointCommand(self.clock.now(), self._group.name, names, positions))
        if look.as_near:
            return
        if problem:
            self._report("failed", problem, given)
        elif measured.keys() >= gaze.positions.keys() and error_rad <= _LOOKED_AT_RAD:
            self._report("done", "", given)

    def _aim(
        self, p_BP: NDArray[np.float64], measured: Mapping[str, float], aimed: Mapping[str, float], in_front: bool
    ) -> tuple[Gaze, float]:
        """Where to look, and the angle (rad) from the axis to the point as the joints were ``measured``."""
        begin = {**measured, **aimed}
        either_way = not (in_front and aimed)
        gaze = aim(self._model, self.settings.eye, self._group.joints, p_BP, begin, either_way=either_way)
        return gaze, gaze_error(self._model, self.settings.eye, p_BP, measured)

    def _report(self, outcome: Accomplished | None, reason: str, given: G | None) -> None:
        if outcome is not None and given is not None:
            params = given.model_dump(mode="json")
            self._accomplishments.report(outcome, reason, lambda desire: desire.params == params)

    def _say(self, problem: str) -> None:
        if problem != self._problem:
            self._problem = problem
            self.log.info("%s", problem or "it looks at its point, or at none")
