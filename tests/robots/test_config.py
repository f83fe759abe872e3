"""The robot's configuration file and what is said about a wrong one."""

from __future__ import annotations

import math
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.link import ArmDescription
from app.messages import GroundTruth, Image, LaserScan
from app.robots.actuator_config import check_footprint, circle
from app.robots.config import RobotConfig, StartPose, load_robot_config
from app.robots.factory import create_link
from app.robots.simulated.body import RobotSimulation, build_simulation
from app.robots.simulated.odometry import TrueBase
from tests.robots.conftest import make_hall


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    return path


def test_the_shipped_robot_has_the_thesiss_limits_and_hides_the_truth() -> None:
    config = load_robot_config(Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.yaml")
    limits = config.limits.base()
    assert (limits.linear_mps, limits.angular_radps, limits.linear_mps2, limits.angular_radps2) == (0.4, 1.0, 0.4, 4.0)
    description = create_link(config, 0.0).description
    assert "ground_truth" not in description.streams
    assert description.simulated
    assert description.model_path.is_file()


def test_streams_are_described_with_type_and_rate(robot: RobotConfig) -> None:
    streams = create_link(robot, time.time()).description.streams
    assert (streams["kinect"].message_type, streams["kinect"].rate_hz) == (Image, 15)
    assert (streams["hokuyo"].message_type, streams["hokuyo"].rate_hz) == (LaserScan, 40)
    assert streams["odometry"].rate_hz == 100
    assert streams["ground_truth"].message_type is GroundTruth


def test_a_sensor_set_to_null_is_not_there(tmp_path: Path, robot: RobotConfig) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\nstreams: {{kinect: null}}\n")
    assert "kinect" not in create_link(load_robot_config(path), 0.0).description.streams


def test_a_missing_model_is_refused_with_its_line(tmp_path: Path, robot: RobotConfig) -> None:
    path = write(tmp_path, f"world: {robot.world}\nmodel: no.urdf\n")
    with pytest.raises(ConfigError, match="there is no file") as refused:
        load_robot_config(path)
    assert refused.value.line == 2


@pytest.mark.parametrize("line", ["limits: {linear_mps: -1}", "colour: red", "streams: {hokuyo: {rays: 1}}"])
def test_what_cannot_be_is_refused_with_its_line(tmp_path: Path, robot: RobotConfig, line: str) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{line}\n")
    with pytest.raises(ConfigError) as refused:
        load_robot_config(path)
    assert refused.value.line == 3


def test_a_stream_that_is_not_there_is_refused_by_name(robot: RobotConfig) -> None:
    link = create_link(robot, 0.0)
    with pytest.raises(KeyError, match=r"no stream 'nose'.*kinect"):
        link.attach("nose", print)
    with pytest.raises(KeyError, match="no stream 'nose'"):
        link.demand("nose", math.inf)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("base: {left_wheel_joint: leg}", "no moving joint 'leg'"),
        ("streams: {hokuyo: {link: nose}}", "no link 'nose'"),
        ("streams: {hokuyo: {link: head_link}}", "moves 'head_link' by the joint 'tilt_joint'; the laser"),
        ("loudspeaker: {link: head_link}", "moves 'head_link' by the joint 'tilt_joint'; the loudspeaker"),
    ],
)
def test_links_and_joints_that_do_not_serve_are_refused(
    tmp_path: Path, robot: RobotConfig, change: str, complaint: str
) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{change}\n")
    with pytest.raises(ConfigError, match=complaint):
        create_link(load_robot_config(path), 0.0)


SQUARE = [(0.3, -0.2), (0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2)]


def test_a_sound_footprint_is_taken_as_it_is() -> None:
    assert check_footprint(tuple(SQUARE)) == tuple(SQUARE)
    assert check_footprint(circle(0.28)) == circle(0.28)
    on_an_edge = (*SQUARE[:2], (0.0, 0.2), *SQUARE[2:])
    assert check_footprint(on_an_edge) == on_an_edge


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        (SQUARE[::-1], "clockwise"),
        ([*SQUARE[:2], (0.1, 0.0), *SQUARE[2:]], "not convex"),
        ([SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]], "not convex"),
        ([*SQUARE, *SQUARE], "not convex"),  # twice round
        ([(x + 0.5, y) for x, y in SQUARE], "does not lie inside"),
        ([(x + 0.3, y) for x, y in SQUARE], "does not lie inside"),
        ([*SQUARE, SQUARE[-1]], "the same"),
        (SQUARE[:2], "at least 3"),
    ],
)
def test_a_footprint_that_cannot_be_is_refused_with_its_line(
    tmp_path: Path, robot: RobotConfig, corners: list[tuple[float, float]], words: str
) -> None:
    text = f"model: {robot.model}\nworld: {robot.world}\nfootprint: {[list(corner) for corner in corners]}\n"
    with pytest.raises(ConfigError, match=words) as refused:
        load_robot_config(write(tmp_path, text))
    assert refused.value.line == 3


@pytest.mark.parametrize("name", ["irl1_tr", "jackal"])
def test_the_footprint_covers_all_of_the_body_and_no_more(name: str) -> None:
    config = load_robot_config(Path(__file__).parents[2] / "config" / "robots" / f"{name}.yaml")
    config = config.model_copy(update={"start": StartPose()})
    model = build_simulation(config, make_hall(), TrueBase(0.1, 0.1, config.base.track_m))
    corners = np.array(config.footprint)
    edges = np.roll(corners, -1, axis=0) - corners
    outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1, keepdims=True)
    reach = (outward * corners).sum(axis=1)
    points = points_of_the_body(model)
    beyond = points[:, :2] @ outward.T - reach
    assert beyond.max() < 0.004
    assert (beyond.max(axis=0) > -0.008).all()  # and every side of it is touched: there is no margin
    assert config.height_m == pytest.approx(points[:, 2].max(), abs=0.02)


def points_of_the_body(simulation: RobotSimulation) -> NDArray[np.float64]:
    """Points (N, 3) on the outside of every shape of the body that is a box, a cylinder or a ball."""
    model, data = simulation.model, simulation.data
    found = []
    turn = np.linspace(0, 2 * math.pi, 32, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for geom in range(model.ngeom):
        if model.body_rootid[model.geom_bodyid[geom]] != simulation.base_body:
            continue
        a, b, c = model.geom_size[geom]
        match model.geom_type[geom]:
            case mujoco.mjtGeom.mjGEOM_BOX:
                local = np.array(np.meshgrid([-a, a], [-b, b], [-c, c])).reshape(3, 8).T
            case mujoco.mjtGeom.mjGEOM_CYLINDER:
                local = np.concatenate([np.column_stack([a * ring, np.full(len(ring), z)]) for z in (-b, b)])
            case _:
                local = np.concatenate(
                    [a * np.insert(ring, axis, 0.0, axis=1) for axis in range(3)],
                )
        found.append(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    return np.concatenate(found)


HEAD = "actuators:\n  head:\n    joints: [pan_joint, tilt_joint]\n    velocity: 9\n"


def test_a_groups_limits_are_the_models_and_the_files(tmp_path: Path, robot: RobotConfig) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{HEAD}")
    group = create_link(load_robot_config(path), 0.0).description.groups["head"]
    assert [(j.name, j.lower, j.upper, j.velocity, j.acceleration) for j in group.joints] == [
        ("pan_joint", -2.234, 2.234, 2.5, 5.0),  # the model allows 2.5 rad/s, the file 9
        ("tilt_joint", -0.2967, 0.4363, 2.5, 5.0),
    ]
    assert not create_link(
        load_robot_config(write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n")), 0.0
    ).description.groups


@pytest.mark.parametrize(
    ("group", "says"),
    [
        (
            "  head:\n    joints: [pan_joint, neck_joint]\n",
            "the model has no movable joint 'neck_joint'; it has left_wheel",
        ),
        ("  head:\n    joints: [pan_joint, torso_joint]\n", "the model has no movable joint 'torso_joint'"),
        ("  head:\n    joints: []\n", "joints"),
        ("  head: {joints: [pan_joint]}\n  neck: {joints: [pan_joint]}\n", "pan_joint is in head already"),
        ("  wheels: {joints: [left_wheel_joint]}\n", "left_wheel_joint is a wheel of the base"),
        ("  base: {joints: [pan_joint]}\n", "base is the group of the wheels"),
        ("  head: {joints: [pan_joint], contact: [8, 8]}\n", "contact has 2 efforts for 1 joints"),
        (
            "  head: {joints: [pan_joint], compliant: true, damping: 50}\n",
            "damping 50 lies outside its damping_range, 0.5 to 40",
        ),
        ("  face: {joints: [eyes_pan_joint], kinematic: true, compliant: true}\n", "a kinematic group has no forces"),
        ("  head: {joints: [pan_joint], stop: rest}\n", "rest moves joints in an emergency stop: only a kinematic"),
        ("  face: {joints: [eyes_pan_joint], kinematic: true, rest: [0, 0]}\n", "rest has 2 positions for 1 joints"),
        ("  face: {joints: [eyes_pan_joint], kinematic: true, rest: [9]}\n", "rest 9 of eyes_pan_joint lies outside"),
    ],
)
def test_a_group_that_cannot_be_is_refused_with_file_and_line(
    tmp_path: Path, robot: RobotConfig, group: str, says: str
) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\nactuators:\n{group}")
    with pytest.raises(ConfigError, match=says) as refused:
        load_robot_config(path)
    assert refused.value.file == str(path)
    if "movable" in says:
        assert refused.value.line == 5


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        ("limits: {lateral_mps: 0.3}\n", "differential"),
        ("base: {drive: holonomic}\n", "lateral_mps above 0"),
        ("base: {drive: tracked}\n", "'differential' or 'holonomic'"),
    ],
)
def test_only_a_holonomic_drive_has_a_sideways_speed(
    tmp_path: Path, robot: RobotConfig, lines: str, problem: str
) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{lines}")
    with pytest.raises(ConfigError, match=problem):
        load_robot_config(path)


def test_the_shipped_holonomic_body_moves_sideways() -> None:
    config = load_robot_config(Path(__file__).parents[2] / "config" / "robots" / "irl1_holonomic.yaml")
    assert config.base.drive == "holonomic"
    description = create_link(config, 0.0).description
    assert description.limits.holonomic
    irl1 = load_robot_config(Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.yaml")
    assert set(description.groups) == set(irl1.actuators)
    assert set(description.streams) == set(create_link(irl1, 0.0).description.streams)


ARM = """actuators:
  arm: {joints: [left_shoulder_pitch_joint, left_elbow_joint]}
  gripper: {joints: [left_gripper_joint]}
arms:
"""


def test_an_arm_is_described_by_its_groups_its_hand_and_its_rest(tmp_path: Path, robot: RobotConfig) -> None:
    left = "  left: {group: arm, hand: left_hand_link, gripper: gripper, rest: [0.1, -0.2]}\n"
    right = "  right: {group: arm, hand: right_hand_link}\n"
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{ARM}{left}{right}")
    assert create_link(load_robot_config(path), 0.0).description.arms == {
        "left": ArmDescription("arm", "left_hand_link", "gripper", (0.1, -0.2)),
        "right": ArmDescription("arm", "right_hand_link", "", (0.0, 0.0)),
    }


@pytest.mark.parametrize(
    ("arm", "says"),
    [
        (
            "left: {group: wing, hand: left_hand_link}",
            "arms.left: there is no actuator group 'wing'; there are arm, grip",
        ),
        ("left: {group: arm, hand: paw}", "the model has no link 'paw'; it has base_link"),
        ("left: {group: arm, hand: left_hand_link, gripper: arm}", "arm has 2 joints; a gripper has one"),
        ("left: {group: arm, hand: left_hand_link, rest: [0]}", "rest has 1 positions for the 2 joints of arm"),
        ("left: {group: arm, hand: left_hand_link, rest: [0, 1]}", "rest: 1 of left_elbow_joint is not within -2.2 to"),
        ("third: {group: arm, hand: left_hand_link}", "third"),
    ],
)
def test_an_arm_that_cannot_be_is_refused_with_file_and_line(
    tmp_path: Path, robot: RobotConfig, arm: str, says: str
) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{ARM}  {arm}\n")
    with pytest.raises(ConfigError, match=says) as refused:
        load_robot_config(path)
    assert (refused.value.file, refused.value.line) == (str(path), 7)


def test_a_sensor_cannot_be_on_a_joint_without_physics(tmp_path: Path, robot: RobotConfig) -> None:
    group = "actuators:\n  head: {joints: [pan_joint, tilt_joint], kinematic: true}\n"
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{group}")
    with pytest.raises(ConfigError, match="moves 'kinect_optical_frame' by the joint 'pan_joint'; a sensor"):
        create_link(load_robot_config(path), 0.0)
