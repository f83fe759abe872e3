"""Clearance of an arm from the rest of the body, against the distances that MuJoCo computes."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pytest

from app.base.collision_shapes import CollisionShape, load_collision_shapes
from app.base.geometry import Pose3
from app.base.kinematic_model import load_model
from app.base.self_collision import SelfCollision

URDF = Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.urdf"
MODEL = load_model(URDF)
SHAPES = load_collision_shapes(URDF)
ARM = tuple(f"left_{joint}_joint" for joint in ("shoulder_pitch", "shoulder_roll", "upper_arm", "elbow"))
COLLISION = SelfCollision(MODEL, SHAPES, ARM)


def physics() -> mujoco.MjModel:
    """The file's collision shapes alone."""
    tree = ElementTree.parse(URDF)
    for link in tree.getroot().findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(tree.getroot(), encoding="unicode"))


def test_hanging_arms_are_free_of_the_body_and_one_across_the_chest_is_not() -> None:
    hanging, across = COLLISION.clearances(np.array([[0.0, 0, 0, 0], [0.0, -0.15, 0, 0]]), {})
    assert hanging.distance_m == pytest.approx(0.01)
    assert (across.moving, across.other) == ("left_forearm_link", "torso_link")
    assert across.distance_m < 0.0


def test_no_clearance_is_greater_than_the_distance_of_the_shapes_and_few_are_much_smaller() -> None:
    model = physics()
    data = mujoco.MjData(model)
    random = np.random.default_rng(6)
    postures = random.uniform([MODEL.joints[n].lower for n in ARM], [MODEL.joints[n].upper for n in ARM], (150, 4))
    others = {
        name: random.uniform(max(joint.lower, -1), min(joint.upper, 1))
        for name, joint in MODEL.joints.items()
        if joint.moves and name not in ARM and "gripper" not in name
    }
    own = [
        n for n in range(model.ngeom)
        if set(MODEL.moved_by(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, int(model.geom_bodyid[n])))) & set(ARM)
    ]  # fmt: skip
    rest = [n for n in range(model.ngeom) if n not in own]
    differences = []
    for posture, clearance in zip(postures, COLLISION.clearances(postures, others), strict=True):
        for name, value in {**others, **dict(zip(ARM, posture, strict=True))}.items():
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        true = min(mujoco.mj_geomDistance(model, data, a, b, 2.0, None) for a in own for b in rest)
        assert clearance.distance_m <= max(true, 0.0) + 0.002, posture
        differences.append(max(true, 0.0) - max(clearance.distance_m, 0.0))
    # Rounded ends reach as far beyond a cylinder's as it is thick.
    assert np.median(differences) < 0.03
    assert max(differences) < 0.06


def test_the_other_arm_is_where_it_is_measured() -> None:
    # Each hand at the same point before the chest.
    forward = np.array([[-1.22, 0.0, -0.8, -1.27]])
    hanging = COLLISION.clearances(forward, {})[0]
    right = ("right_shoulder_pitch_joint", "right_shoulder_roll_joint", "right_upper_arm_joint", "right_elbow_joint")
    crossing = dict(zip(right, (-1.36, 0.05, 1.0, -1.14), strict=True))
    crossed = COLLISION.clearances(forward, crossing)[0]
    assert crossed.distance_m < 0.0 < hanging.distance_m
    assert crossed.other.startswith("right_")


def test_links_that_overlap_at_zero_are_not_compared() -> None:
    fat = CollisionShape("torso_link", "box", Pose3.identity(), np.array([0.2, 0.4, 0.8]))
    mounted = SelfCollision(MODEL, [*(shape for shape in SHAPES if shape.link != "torso_link"), fat], ARM)
    assert mounted.clearances(np.zeros((1, 4)), {})[0].other != "torso_link"


def test_joints_that_move_no_shape_are_clear_of_everything() -> None:
    nothing = SelfCollision(MODEL, [shape for shape in SHAPES if shape.link == "torso_link"], ARM)
    assert [clearance.distance_m for clearance in nothing.clearances(np.zeros((2, 4)), {})] == [np.inf, np.inf]
