"""LookAt: turns the head so that a camera looks at a point.

    ┌───────────────────────────────────────────────────────────────────────────────────────────────┐
    │ LookAt    in   joints           JointState, 30 Hz; never filtered                             │
    │           in   odometry         Odometry, X_OB in odom; never filtered                        │
    │           in   localization     Localization, X_MO on the map: for points on the map          │
    │           out  command          JointCommand of the group (rad), 10 Hz while there is a point │
    │           out  accomplishments  Accomplishment, when the eye looks at the point               │
    └───────────────────────────────────────────────────────────────────────────────────────────────┘

The point comes with the desire LookAt: in ``base_link`` it turns with the robot; in ``odom`` or ``map`` the head
follows it while the robot drives, so the desire stays once it is accomplished. Where the joints cannot reach it, the
head looks as near to it as they can, and the desire has failed for the time being.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.kinematic_model import KinematicModel, load_model
from app.link import ActuatorGroup
from app.maps.zones import FURTHEST_M
from app.messages import JointCommand, JointState, Localization, Odometry
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.gaze.gaze_kinematics import Gaze, aim, gaze_error
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext, Settings

Frame = Literal["base_link", "odom", "map"]

#: States of localization whose pose is good enough to aim by.
_LOCALIZED = ("mapping", "tracking")
#: Up to this angle (rad) beside the optical axis the point is looked at.
_LOOKED_AT_RAD = math.radians(2)


class LookAtSettings(Settings):
    """Settings of LookAt."""

    group: str = Field("head", min_length=1, description="actuator group that moves the eye")
    eye: str = Field(
        min_length=1, description="optical frame of the camera that looks (z forward), a link of the model"
    )
    period_s: float = Field(0.1, gt=0, le=0.2, description="time between two commands")


class LookAtParameters(BaseModel):
    """Parameters of a desire of class LookAt."""

    model_config = ConfigDict(extra="forbid", title="Look at a point", allow_inf_nan=False)

    x: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="x", description="The point, in metres in its frame.")
    y: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="y", description="The point, in metres in its frame.")
    z: float = Field(1.2, ge=-100, le=100, title="z", description="Its height, in metres above the floor.")
    frame: Frame = Field(
        "odom", title="Frame", description="base_link: it turns with the robot; odom or map: it stays in the room."
    )


LOOK_AT = DesireClass(
    name="LookAt",
    title="Look at a point",
    description="Turn the head so that the camera looks at a point, as long as it is desired.",
    parameters=LookAtParameters,
)


@dataclass(frozen=True, slots=True)
class PointOfInterest:
    """A point ``p_FP`` (3,) m in ``frame``."""

    p_FP: NDArray[np.float64]
    frame: Frame

    def in_base(self, X_OB: Pose2 | None, X_MO: Pose2 | None) -> NDArray[np.float64] | None:
        """``p_BP`` (3,) for the robot at ``X_OB`` in odom, odom at ``X_MO`` on the map; None where its frame is not
        known."""
        if self.frame == "base_link":
            return self.p_FP
        if X_OB is None or (self.frame == "map" and X_MO is None):
            return None
        X_FB = X_MO @ X_OB if self.frame == "map" and X_MO is not None else X_OB
        return np.asarray(X_FB.to_pose3().inverse().transform(self.p_FP))


class LookAt(Module):
    """Looks at a point with the joints of the head."""

    title = "Look at"
    desire_classes = (LOOK_AT,)
    Settings = LookAtSettings
    settings: LookAtSettings
    auxiliary_inputs = frozenset({"localization"})

    _model: KinematicModel
    _group: ActuatorGroup

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.joints = self.input("joints", JointState, always_open=True)
        self.odometry = self.input("odometry", Odometry, always_open=True)
        self.localization = self.input("localization", Localization)
        self.command = self.output("command", JointCommand)
        self._accomplishments = AccomplishmentReporter(self, LOOK_AT.name)
        self.on(self.joints, self._take_joints)
        self.on(self.odometry, self._take_odometry)
        self.on(self.localization, self._take_localization)
        self.every(self.settings.period_s, self._beat)
        self._given: Mapping[str, Any] = {}
        self._point: PointOfInterest | None = None
        self._measured: Mapping[str, float] = {}
        self._aimed: Mapping[str, float] = {}
        self._X_OB: Pose2 | None = None
        self._X_MO: Pose2 | None = None
        self._problem = ""

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

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the point from the desire; without ``x`` and ``y`` there is none."""
        if "x" in parameters and "y" in parameters:
            given = LookAtParameters.model_validate(
                {key: parameters[key] for key in LookAtParameters.model_fields if key in parameters}
            )
            self._given = given.model_dump(mode="json")
            self._point = PointOfInterest(np.array([given.x, given.y, given.z]), given.frame)
        else:
            self._point = None

    async def _take_joints(self, joints: JointState) -> None:
        self._measured = dict(zip(joints.names, joints.positions, strict=True))

    async def _take_odometry(self, odometry: Odometry) -> None:
        self._X_OB = odometry.X_OB

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO if localization.state in _LOCALIZED else None

    def cautions(self) -> tuple[Caution, ...]:
        return self._accomplishments.cautions()

    async def _beat(self) -> None:
        if self._point is None or not self.command.wanted:
            self._aimed = {}
            self._say("")
            return
        p_BP = self._point.in_base(self._X_OB, self._X_MO)
        if p_BP is None:
            self._say(f"it waits: where the robot is in {self._point.frame} is not known")
            return
        given, measured = self._given, self._measured
        gaze, error_rad = await self.compute(self._aim, p_BP, measured, {**measured, **self._aimed})
        self._aimed = gaze.positions
        problem = f"the point is out of the {self._group.name}'s reach" if gaze.error_rad > _LOOKED_AT_RAD else ""
        self._say(problem)
        names, positions = tuple(gaze.positions), tuple(gaze.positions.values())
        self.command.publish(JointCommand(self.clock.now(), self._group.name, names, positions))
        if problem:
            self._accomplishments.report("failed", problem, lambda desire: desire.params == given)
        elif measured.keys() >= gaze.positions.keys() and error_rad <= _LOOKED_AT_RAD:
            self._accomplishments.report("done", "", lambda desire: desire.params == given)

    def _aim(
        self, p_BP: NDArray[np.float64], measured: Mapping[str, float], begin: Mapping[str, float]
    ) -> tuple[Gaze, float]:
        """Where to look, and the angle (rad) from the axis to the point as the joints were ``measured``."""
        eye = self.settings.eye
        return aim(self._model, eye, self._group.joints, p_BP, begin), gaze_error(self._model, eye, p_BP, measured)

    def _say(self, problem: str) -> None:
        if problem != self._problem:
            self._problem = problem
            self.log.info("%s", problem or "it looks at the point, or at none")
