"""The arms of the robot's file, for tests of what is in front of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.self_collision import SelfCollision
from app.messages import JointState
from app.robots.config import load_robot_config
from tests.modules.fakes import FakeLink

BODY = load_robot_config(Path(__file__).parents[3] / "config" / "robots" / "irl1_tr.yaml")
MODEL = load_model(BODY.model)
SHAPES = load_collision_shapes(BODY.model)
GROUPS = BODY.groups
LEFT, RIGHT = GROUPS["left_arm"], GROUPS["right_arm"]
LEFT_NAMES, RIGHT_NAMES = (tuple(joint.name for joint in group.joints) for group in (LEFT, RIGHT))
COLLISION = SelfCollision(MODEL, SHAPES, LEFT_NAMES)
JOINTS = tuple(joint.name for group in GROUPS.values() for joint in group.joints)
#: Each hand at the same point before the chest, free of the body but for the other arm.
LEFT_CROSSING = (-1.22, 0.0, -0.8, -1.27)
RIGHT_CROSSING = (-1.36, 0.05, 1.0, -1.14)
#: Inside the torso.
INTO_THE_TORSO = (0.0, -0.15, 0.0, 0.0)
REST = (0.0, 0.1, 0.0, -0.2)


def link() -> FakeLink:
    """A body without physics that has IRL-1's groups and arms."""
    fake = FakeLink()
    fake.description = replace(
        fake.description, model_path=BODY.model, groups=dict(GROUPS), arms=dict(BODY.arm_descriptions)
    )
    return fake


def joint_state(stamp: float, left: tuple[float, ...], right: tuple[float, ...] = (0.0, -0.1, 0.0, -0.2)) -> JointState:
    """All joints of groups; those that are not given are at 0."""
    positions = dict.fromkeys(JOINTS, 0.0) | dict(zip(LEFT_NAMES + RIGHT_NAMES, left + right, strict=True))
    return JointState(stamp, tuple(positions), tuple(positions.values()))
