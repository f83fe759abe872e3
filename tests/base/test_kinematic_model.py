"""The model reader against MuJoCo's own kinematics, and its complaints."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.base.kinematic_model import load_model

URDF = Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.urdf"
MODEL = load_model(URDF)
PHYSICS = mujoco.MjSpec.from_file(str(URDF)).compile()


@given(st.floats(-2.2, 2.2), st.floats(-0.29, 0.43), st.floats(-2.0, 0.0), st.floats(0.0, 0.04))
def test_forward_kinematics_agrees_with_the_physics(pan: float, tilt: float, elbow: float, finger: float) -> None:
    positions = {"pan_joint": pan, "tilt_joint": tilt, "left_elbow_joint": elbow, "left_gripper_joint": finger}
    data = mujoco.MjData(PHYSICS)
    data.qpos[PHYSICS.joint("left_gripper_second_joint").qposadr[0]] = finger
    for name, position in positions.items():
        data.qpos[PHYSICS.joint(name).qposadr[0]] = position
    mujoco.mj_kinematics(PHYSICS, data)
    links = ("kinect_optical_frame", "left_forearm_link", "right_wheel_link", "hokuyo_link", "left_hand_link")
    for link in (*links, "left_finger_1_link", "left_finger_2_link"):
        pose = MODEL.pose(link, positions)
        np.testing.assert_allclose(pose.translation, data.body(link).xpos, atol=1e-9)
        np.testing.assert_allclose(pose.rotation, data.body(link).xmat.reshape(3, 3), atol=1e-9)


@given(st.lists(st.floats(-0.1, 0.9), min_size=4, max_size=4), st.floats(0.0, 0.04))
def test_the_jacobian_agrees_with_the_physics(shares: list[float], finger: float) -> None:
    names = ("left_shoulder_pitch_joint", "left_shoulder_roll_joint", "left_upper_arm_joint", "left_elbow_joint")
    joints = (*names, "left_gripper_joint", "pan_joint")
    positions = dict(zip(names, shares, strict=True)) | {"left_gripper_joint": finger}
    data = mujoco.MjData(PHYSICS)
    for name, position in (positions | {"left_gripper_second_joint": finger}).items():
        data.qpos[PHYSICS.joint(name).qposadr[0]] = position
    mujoco.mj_kinematics(PHYSICS, data)
    mujoco.mj_comPos(PHYSICS, data)
    for link in ("left_hand_link", "left_finger_2_link"):
        expected = np.zeros((3, PHYSICS.nv))
        body = data.body(link)
        mujoco.mj_jac(PHYSICS, data, expected, None, body.xpos, body.id)
        columns = [expected[:, PHYSICS.joint(name).dofadr[0]].copy() for name in joints]
        columns[4] += expected[:, PHYSICS.joint("left_gripper_second_joint").dofadr[0]]
        np.testing.assert_allclose(MODEL.jacobian(link, joints, positions), np.column_stack(columns), atol=1e-9)


def test_the_frames_the_sensors_need_are_where_the_thesis_has_them() -> None:
    laser = MODEL.pose("hokuyo_link")
    assert laser.translation[2] == pytest.approx(0.40)
    camera = MODEL.pose("kinect_optical_frame")
    np.testing.assert_allclose(camera.rotation[:, 2], [1, 0, 0], atol=1e-12)  # it looks forward
    np.testing.assert_allclose(camera.rotation[:, 1], [0, 0, -1], atol=1e-12)  # its y points down
    assert 1.2 < camera.translation[2] < 1.4


def test_the_head_moves_within_the_thesiss_limits_and_tilting_up_looks_up() -> None:
    pan, tilt = MODEL.joints["pan_joint"], MODEL.joints["tilt_joint"]
    assert np.rad2deg([pan.lower, pan.upper]) == pytest.approx([-128, 128], abs=0.01)
    assert np.rad2deg([tilt.lower, tilt.upper]) == pytest.approx([-17, 25], abs=0.01)
    assert MODEL.pose("kinect_optical_frame", {"tilt_joint": 0.3}).rotation[2, 2] == pytest.approx(math.sin(0.3))


def test_a_link_names_the_joints_that_move_it() -> None:
    assert MODEL.moved_by("kinect_optical_frame") == ("tilt_joint", "pan_joint")
    assert MODEL.moved_by("hokuyo_link") == ()
    with pytest.raises(KeyError, match="no link 'nose'"):
        MODEL.moved_by("nose")


def test_two_arms_of_four_joints_and_a_gripper() -> None:
    for side in ("left", "right"):
        arm = [n for n in MODEL.joint_names if n.startswith(side) and "wheel" not in n]
        assert len(arm) == 5
        assert arm[-1] == f"{side}_gripper_joint"


def test_eyes_turn_together() -> None:
    assert "right_eye_pan_joint" not in MODEL.joint_names
    assert MODEL.moved_by("right_eye_link") == ("eyes_pan_joint", "eyes_tilt_joint", "tilt_joint", "pan_joint")
    looking = {"eyes_pan_joint": 0.3, "eyes_tilt_joint": -0.2}
    left, right = (MODEL.pose(f"{side}_eye_link", looking).rotation for side in ("left", "right"))
    np.testing.assert_allclose(left, right)


def test_a_joint_that_follows_another_is_moved_by_it() -> None:
    assert "left_gripper_second_joint" not in MODEL.joint_names
    assert MODEL.moved_by("left_finger_2_link")[0] == "left_gripper_joint"
    assert MODEL.position("left_gripper_second_joint", {"left_gripper_joint": 0.02}) == 0.02


def test_an_unknown_link_is_named_with_those_there_are() -> None:
    with pytest.raises(KeyError, match=r"no link 'nose'.*base_link"):
        MODEL.pose("nose")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("<robot><link", "is no XML"),
        ("<robot><joint name='j' type='fixed'><parent link='a'/></joint></robot>", "has no <child>"),
        ("<robot><link name='a'/><link name='b'/></robot>", "one tree; these have no parent: a, b"),
        (
            (
                "<robot><link name='a'/><link name='b'/><joint name='j' type='prismatic'><parent link='a'/>"
                "<child link='b'/><mimic joint='k'/></joint></robot>"
            ),
            "j mimics 'k', which is no movable joint",
        ),
    ],
)
def test_a_file_that_is_no_robot_is_refused_in_words(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(ConfigError, match=complaint):
        load_model(path)


def test_a_missing_file_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read"):
        load_model(tmp_path / "nothing.urdf")
