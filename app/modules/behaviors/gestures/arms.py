"""The arms of a body as gestures use them: groups, kinematics, shapes and posture at rest, from its description."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.self_collision import SelfCollision
from app.link import ActuatorGroup, RobotDescription
from app.modules.arm_way import PLANNING_MARGIN_M, touching, way
from app.modules.behaviors.gestures.arm_kinematics import ArmKinematics, OutOfReach, Pointing, arm_kinematics

Vector = NDArray[np.float64]

POINTING_ERROR_RAD = math.radians(5)
"""Greatest angle at the shoulder between an arm that points and the point."""
#: Distances of the hand of a bent arm that points, as shares of the arm's reach.
_BENT = (0.97, 0.9, 0.8)
#: An arm that goes around its body is so far (rad) aside of its rest.
_ASIDE_RAD = 0.4


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
        return postures[[clearance.distance_m >= PLANNING_MARGIN_M for clearance in clearances]]

    def pointing(self, p_BP: Vector, measured: Mapping[str, float]) -> Pointing:
        """The posture that points at ``p_BP`` (3,) m: straight, or bent where the straight arm would touch the body or
        stay too far beside; as straight as can be where neither helps. Raises OutOfReach."""
        straight = self.kinematics.point(p_BP, self.rest)
        if straight.error_rad <= POINTING_ERROR_RAD and len(self.free(straight.positions[None], measured)):
            return straight
        shoulder = self.kinematics.X_BS.translation
        direction = (p_BP - shoulder) / np.linalg.norm(p_BP - shoulder)
        for share in _BENT:
            try:
                postures = self.kinematics.reach(shoulder + direction * share * self.kinematics.reach_m, self.rest)
            except OutOfReach:
                continue
            if len(free := self.free(postures, measured)):
                return Pointing(free[0], 0.0)
        return straight

    def route(self, goal: Vector, measured: Mapping[str, float]) -> list[Vector] | str:
        """The postures (4,) rad by which the arm comes to ``goal`` without touching the body, ``goal`` the last; where
        there are none, what it would touch on the straight way, in words.

        Where the straight way is barred, the arm goes around with its roll further outwards, or by way of its rest.
        """
        here = self.positions(measured)
        problem = self._touching([here, goal], measured)
        if not problem:
            return [goal]
        for outwards in self._outwards():
            lifted, beside = (np.array([q[0], outwards, q[2], q[3]]) for q in (here, goal))
            for route in ([beside, goal], [lifted, goal], [lifted, beside, goal]):
                if not self._touching([here, *route], measured):
                    return route
        return problem if self._touching([here, self.rest, goal], measured) else [self.rest, goal]

    def _outwards(self) -> tuple[float, ...]:
        """Positions (rad) of the roll joint at which the arm is away from the body: the side to which it moves
        further."""
        roll, rest = self.kinematics.joints[1], float(self.rest[1])
        further = rest + math.copysign(_ASIDE_RAD, roll.upper + roll.lower)
        return rest, min(max(further, roll.lower), roll.upper)

    def _touching(self, postures: Sequence[Vector], measured: Mapping[str, float]) -> str:
        for begin, goal in itertools.pairwise(postures):
            leg = way(self.kinematics.joints, begin, goal)
            if problem := touching(self.collision, leg, measured, PLANNING_MARGIN_M):
                return problem
        return ""


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
