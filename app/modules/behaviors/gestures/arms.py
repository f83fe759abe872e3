"""The arms of a body as gestures use them: groups, kinematics, shapes and posture at rest, from its description."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.self_collision import SelfCollision
from app.link import ActuatorGroup, RobotDescription
from app.modules.actuation.arm_way import MARGIN_M, touching, way
from app.modules.behaviors.gestures.arm_kinematics import ArmKinematics, arm_kinematics

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """One arm: its ``side``, the groups of its joints and of its gripper (None: it has none), and the positions (4,)
    rad at ``rest``. Positions of the arm's joints are in the order of ``kinematics.joints`` everywhere."""

    side: str
    group: ActuatorGroup
    gripper: ActuatorGroup | None
    kinematics: ArmKinematics
    collision: SelfCollision
    rest: Vector

    @property
    def names(self) -> tuple[str, ...]:
        """The joints' names, from the shoulder to the elbow."""
        return self.kinematics.names

    def positions(self, measured: Mapping[str, float]) -> Vector:
        """The joints' positions (4,) rad of all that are ``measured``, by name; KeyError for one that is not."""
        return np.array([measured[name] for name in self.names])

    def free(self, postures: Vector, measured: Mapping[str, float]) -> Vector:
        """Those of ``postures`` (N, 4) rad at which the arm touches nothing of the body."""
        clearances = self.collision.clearances(postures, measured)
        return postures[[clearance.distance_m >= MARGIN_M for clearance in clearances]]

    def blocked(self, goal: Vector, measured: Mapping[str, float]) -> str:
        """What the arm would touch on its way to the posture ``goal`` (4,), in words; "" where the way is free."""
        return touching(self.collision, way(self.kinematics.joints, self.positions(measured), goal), measured)


def load_arms(body: RobotDescription, sides: Collection[str] = ("left", "right")) -> dict[str, Arm]:
    """The arms of ``body`` by side, those of ``sides`` that it has.

    Raises ConfigError for a model that cannot be read, OtherArm for an arm of another kind.
    """
    model, shapes = load_model(body.model_path), load_collision_shapes(body.model_path)
    arms = {}
    for side, description in body.arms.items():
        if side not in sides:
            continue
        group = body.groups[description.group]
        kinematics = arm_kinematics(model, group.joints, description.hand)
        rest = {joint.name: position for joint, position in zip(group.joints, description.rest, strict=True)}
        arms[side] = Arm(
            side,
            group,
            body.groups[description.gripper] if description.gripper else None,
            kinematics=kinematics,
            collision=SelfCollision(model, shapes, kinematics.names),
            rest=np.array([rest[name] for name in kinematics.names]),
        )
    return arms
