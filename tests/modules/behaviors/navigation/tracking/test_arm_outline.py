"""When arms count as part of the body: of IRL-1 as its file describes it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base import paths
from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.moving_shapes import BodyOutline, MovingShapes
from app.modules.behaviors.navigation.tracking.arm_outline import ArmOutline
from app.robots.config import load_robot_config

IRL1 = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
JOINTS = [joint.name for group in IRL1.groups.values() for joint in group.joints]
SHAPES = MovingShapes(load_model(IRL1.model), load_collision_shapes(IRL1.model), JOINTS)
REST = {
    joint.name: position
    for arm in IRL1.arms.values()
    for joint, position in zip(IRL1.groups[arm.group].joints, arm.rest, strict=True)
}
ASIDE = REST | {"left_shoulder_roll_joint": math.pi / 2, "left_elbow_joint": 0.0}


@pytest.fixture
def arms() -> ArmOutline:
    return ArmOutline(BodyOutline(IRL1.footprint, SHAPES), IRL1.footprint)


def test_arms_at_rest_leave_the_footprint_as_it_is(arms: ArmOutline) -> None:
    assert not arms.update(REST)
    assert arms.corners is IRL1.footprint
    assert not arms.stretched


def test_a_stretched_arm_is_part_of_the_body_until_it_rests_again(arms: ArmOutline) -> None:
    arms.update(REST)
    assert arms.update(ASIDE)
    assert arms.stretched
    corners = np.array(arms.corners)
    assert corners[:, 1].max() == pytest.approx(0.2 + 0.55, abs=0.03)
    assert corners[:, 1].min() == pytest.approx(-0.295, abs=0.005)
    assert arms.update(REST)
    assert arms.corners is IRL1.footprint


def test_trembling_and_joints_that_move_no_arm_change_nothing(arms: ArmOutline) -> None:
    arms.update(ASIDE)
    before = arms.corners
    assert not arms.update(ASIDE | {"left_shoulder_roll_joint": math.pi / 2 - 0.008})
    assert not arms.update(ASIDE | {"eyelids_joint": 1.0})
    assert arms.corners is before
