"""Where the moving parts of the robot are: against the physics' own shapes, and what bounds them all."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.moving_shapes import BodyOutline, Corners, MovingShapes, convex_hull

URDF = Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.urdf"
MODEL = load_model(URDF)
PHYSICS = mujoco.MjSpec.from_file(str(URDF)).compile()
ARMS = tuple(
    f"{side}_{joint}_joint"
    for side in ("left", "right")
    for joint in ("shoulder_pitch", "shoulder_roll", "upper_arm", "elbow")
)
SHAPES = MovingShapes(MODEL, load_collision_shapes(URDF), (*ARMS, "left_gripper_joint", "right_gripper_joint"))
FOOTPRINT: Corners = tuple((0.28 * math.cos(a), 0.28 * math.sin(a)) for a in np.arange(16) * math.pi / 8)
OUTLINE = BodyOutline(FOOTPRINT, SHAPES)

postures = st.fixed_dictionaries(
    {name: st.floats(MODEL.joints[name].lower, MODEL.joints[name].upper) for name in ARMS}
    | {name: st.floats(0.0, 0.04) for name in ("left_gripper_joint", "right_gripper_joint")}
)


def on_the_arms(positions: dict[str, float]) -> NDArray[np.float64]:
    """Points (N, 3) on the arms' collision shapes, as the physics places them."""
    data = mujoco.MjData(PHYSICS)
    for name, position in positions.items():
        data.qpos[PHYSICS.joint(name).qposadr[0]] = position
        if name.endswith("gripper_joint"):
            data.qpos[PHYSICS.joint(name.replace("gripper", "gripper_second")).qposadr[0]] = position
    mujoco.mj_kinematics(PHYSICS, data)
    turns = np.arange(24) * math.pi / 12
    found = []
    for geom in range(PHYSICS.ngeom):
        if not PHYSICS.geom_contype[geom] or PHYSICS.body(PHYSICS.geom_bodyid[geom]).name not in SHAPES.links:
            continue
        a, b, c = PHYSICS.geom_size[geom]
        if PHYSICS.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER:
            ring = np.column_stack([a * np.cos(turns), a * np.sin(turns), np.full(24, b)])
            local = np.concatenate([ring, ring * [1, 1, -1]])
        else:
            local = np.array([[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)])
        found.append(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    return np.concatenate(found)


def inside(corners: Corners, points: NDArray[np.float64]) -> bool:
    """Whether all of ``points`` (N, 2) are within the convex polygon, to a millimetre."""
    polygon = np.array(corners)
    sides = np.roll(polygon, -1, axis=0) - polygon
    normals = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.linalg.norm(sides, axis=1)[:, None]
    return bool((points @ normals.T <= (normals * polygon).sum(axis=1) + 1e-3).all())


@given(postures)
def test_the_outline_is_around_the_arms_and_the_footprint_and_the_widest_around_it(positions: dict[str, float]) -> None:
    outline = OUTLINE.at(positions)
    points = on_the_arms(positions)
    # A cylinder is covered but for the rims of its flat ends, which its neighbours' capsules mostly hide.
    assert inside(outline, points[:, :2] * 0.97)
    assert inside(outline, np.array(FOOTPRINT))
    assert inside(OUTLINE.widest, np.array(outline))


@given(postures)
def test_points_on_an_arm_are_in_its_capsules_and_points_beside_it_are_not(positions: dict[str, float]) -> None:
    capsules = SHAPES.at(positions)
    points = on_the_arms(positions)
    assert capsules.contains(points, 0.02).all()
    far = points + np.array([0.0, 0.0, 3.0])
    assert not capsules.contains(far, 0.02).any()


def test_hanging_arms_leave_the_footprint_as_it_is() -> None:
    assert OUTLINE.at({}) is FOOTPRINT


def test_an_arm_stretched_forward_is_ahead_of_the_footprint() -> None:
    outline = np.array(OUTLINE.at({"left_shoulder_pitch_joint": -math.pi / 2}))
    assert outline[:, 0].max() == pytest.approx(-0.03 + 0.55, abs=0.02)
    assert outline[outline[:, 0] > 0.3, 1].min() > 0.1, "on the left alone"


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=3, max_size=40))
@example([(0.0, 1.0), (0.0, 0.5), (1e-38, 0.0), (-1.0, 0.0)])  # a side that is upright but for rounding
def test_a_hull_is_convex_counter_clockwise_and_around_all_points(points: list[tuple[float, float]]) -> None:
    hull = convex_hull(points)
    if len(hull) < 3:
        return  # all in one line
    corners = np.array(hull)
    sides = np.roll(corners, -1, axis=0) - corners
    after = np.roll(sides, -1, axis=0)
    assert (sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0] > 0).all()
    assert inside(hull, np.array(points))
