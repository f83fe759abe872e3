"""A mapping proposed from topics: what it takes, what it says is missing; and that it is a mapping."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base import paths
from app.cli import main
from app.robots.ros2.config import (
    CAMERA_INFO,
    IMAGE,
    POSITIONS,
    TRAJECTORY,
    TWIST,
    TWIST_STAMPED,
    TYPES,
    load_ros2_config,
)
from app.robots.ros2.proposal import Proposal, Topic, propose
from tests.logs.importers import bags

ODOMETRY = Topic("/odom", TYPES["odometry"], rate_hz=19.96)
SCAN = Topic("/scan", TYPES["hokuyo"], rate_hz=7.52, frame="rplidar_link")
JOINTS = Topic("/joint_states", TYPES["joints"], rate_hz=20.1)
BATTERY = Topic("/battery_state", TYPES["battery"], rate_hz=0.21)
COMMANDS = Topic("/cmd_vel", TWIST_STAMPED, publishers=0, subscribers=1)
WHOLE = [ODOMETRY, SCAN, JOINTS, BATTERY, COMMANDS]
MEASURE_IT = "watchdog: after how long"


def written(proposal: Proposal, folder: Path) -> Path:
    """The proposal as a file, with a model and a program that there are."""
    robots = paths.config_dir() / "robots"
    text = proposal.text.replace("model: robot.urdf", f"model: {robots / 'turtlebot4.urdf'}")
    text = text.replace("program: turtlebot4.yaml", f"program: {robots.parent / 'turtlebot4.yaml'}")
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    return path


def test_a_whole_robot_is_mapped(tmp_path: Path) -> None:
    proposal = propose(WHOLE, {"base_link": True, "rplidar_link": True})
    assert proposal.drivable
    assert [sentence[: len(MEASURE_IT)] for sentence in proposal.missing] == [MEASURE_IT]
    assert proposal.remarks == ()
    config = load_ros2_config(written(proposal, tmp_path))
    assert {name: (topic.topic, topic.rate_hz) for name, topic in config.mapped.items()} == {
        "odometry": ("/odom", 20.0), "joints": ("/joint_states", 20.0), "hokuyo": ("/scan", 7.5),
        "battery": ("/battery_state", 0.21),
    }  # fmt: skip
    assert config.streams.hokuyo is not None
    assert config.streams.hokuyo.link == "rplidar_link"
    assert (config.base.topic, config.base.type, config.base.watchdog_s) == ("/cmd_vel", TWIST_STAMPED, None)
    assert config.graph.clock == "header"


def test_topics_of_set_points_are_named() -> None:
    arm = Topic("/arm_controller/joint_trajectory", TRAJECTORY, publishers=0, subscribers=1)
    (remark,) = propose([*WHOLE, arm, Topic("/nobody/commands", POSITIONS)]).remarks
    assert remark.startswith("joints: set-points are taken on /arm_controller/joint_trajectory: ")


@pytest.mark.parametrize("left_out", range(len(WHOLE)))
def test_what_is_missing_is_said_and_the_rest_is_mapped(tmp_path: Path, left_out: int) -> None:
    topics = WHOLE[:left_out] + WHOLE[left_out + 1 :]
    proposal = propose(topics)
    gone = WHOLE[left_out]
    assert any(gone.type in sentence for sentence in proposal.missing)
    assert proposal.drivable is (gone not in (ODOMETRY, COMMANDS))
    assert len(load_ros2_config(written(proposal, tmp_path)).mapped) == len(topics) - (gone is not COMMANDS) + (
        gone is ODOMETRY  # without a topic named it is odom
    )


def test_nothing_at_all_is_a_mapping_to_be_filled_in(tmp_path: Path) -> None:
    proposal = propose([])
    assert not proposal.drivable
    assert len(proposal.missing) == len(TYPES) + 1, "all but the IMU, and the base with its watchdog"
    load_ros2_config(written(proposal, tmp_path))


def test_the_likeliest_of_several_is_taken_and_the_others_are_named() -> None:
    other = Topic("/a/odometry/filtered", TYPES["odometry"], rate_hz=30.0)
    unstamped = Topic("/diff_drive_controller/cmd_vel_unstamped", TWIST, publishers=1, subscribers=1)
    proposal = propose([other, unstamped, *WHOLE])
    assert "{topic: /odom, " in proposal.text
    assert "odometry: /odom was chosen; there are also /a/odometry/filtered." in proposal.remarks
    assert f"base: /cmd_vel was chosen; there are also {unstamped.name} ({TWIST})." in proposal.remarks


def test_a_laser_that_the_model_does_not_have_is_missing() -> None:
    absent = propose(WHOLE, {"base_link": True, "laser": True}).missing
    assert "laser: the model has no link 'rplidar_link', which its scans name; it has base_link, laser." in absent
    moved = propose(WHOLE, {"rplidar_link": False}).missing
    assert "laser: a joint of the model moves 'rplidar_link'; it must be fixed to the base." in moved


def test_a_wrong_clock_and_a_simulated_one_are_noticed() -> None:
    late = Topic("/odom", TYPES["odometry"], rate_hz=20.0, ahead_s=-3600.0)
    assert any("the robot's is 3600.0 s behind this computer's" in s for s in propose([late, *WHOLE[1:]]).missing)
    simulated = propose([late, *WHOLE[1:], Topic("/clock", "rosgraph_msgs/msg/Clock")])
    assert "clock: sim" in simulated.text
    assert not any("behind" in sentence for sentence in simulated.missing)


def test_what_is_not_mapped_yet_is_named() -> None:
    clouds = Topic("/points", "sensor_msgs/msg/PointCloud2")
    remarks = propose([*WHOLE, clouds, Topic("/tf", "tf2_msgs/msg/TFMessage")]).remarks
    assert remarks == ("Topics of clouds and frames are not mapped yet: /points, /tf.",)


def test_an_inertial_sensor_is_mapped_and_an_action_is_named(tmp_path: Path) -> None:
    imu = Topic("/imu", TYPES["imu"], rate_hz=98.0, frame="rplidar_link")
    feedback = Topic("/arm/follow/_action/feedback", "control_msgs/action/FollowJointTrajectory_FeedbackMessage")
    proposal = propose([*WHOLE, imu, feedback], {"base_link": True, "rplidar_link": True})
    sensor = load_ros2_config(written(proposal, tmp_path)).streams.imu
    assert sensor is not None
    assert (sensor.topic, sensor.rate_hz, sensor.link) == ("/imu", 98.0, "rplidar_link")
    assert proposal.remarks == (
        "joints: trajectories are taken by the action /arm/follow: name the groups in actuators and joint_commands.",
    )
    missing = propose([*WHOLE, imu], {"base_link": True}).missing
    assert (
        "inertial sensor: the model has no link 'rplidar_link', which its messages name; it has base_link." in missing
    )


def test_a_bag_is_looked_at(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sent = [
        bags.Sent(k * 10**8, topic, kind, fields)
        for k in range(1, 12)
        for topic, kind, fields in (
            ("/odom", TYPES["odometry"], {"header": bags.header(k * 10**8, "odom")}),
            ("/base_scan", TYPES["hokuyo"], {"header": bags.header(k * 10**8, "laser"), "ranges": [1.0, 2.0]}),
            ("/cmd_vel", TWIST, {}),
        )
    ]
    folder = bags.write_ros2_sqlite(tmp_path / "run", sent)
    assert main(["ros", "map", str(folder)]) == 0
    said = capsys.readouterr()
    assert "  odometry: {topic: /odom, rate_hz: 10}\n" in said.out
    assert "  hokuyo: {topic: /base_scan, rate_hz: 10, link: laser}\n" in said.out
    assert f"  topic: /cmd_vel\n  type: {TWIST}\n" in said.out
    assert "missing: joints: no topic of the type" in said.err


def test_a_bag_that_is_not_there_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ros", "map", str(tmp_path / "none")]) == 2
    assert f"{tmp_path / 'none'}: is a bag that cannot be read" in capsys.readouterr().err


COLOR = Topic("/head/color/image_raw", IMAGE, rate_hz=14.9, frame="camera_optical", holds="color")
INFO = Topic("/head/color/camera_info", CAMERA_INFO)


def test_a_camera_is_mapped_with_its_calibration(tmp_path: Path) -> None:
    proposal = propose([*WHOLE, COLOR, INFO], {"base_link": True, "rplidar_link": True, "camera_optical": False})
    assert [sentence[: len(MEASURE_IT)] for sentence in proposal.missing] == [MEASURE_IT]
    path = written(proposal, tmp_path)
    path.write_text(path.read_text("utf-8").replace("camera_optical", "oakd_rgb_camera_optical_frame"), "utf-8")
    camera = load_ros2_config(path).streams.camera
    assert camera is not None
    assert (camera.topic, camera.info_topic, camera.rate_hz) == (COLOR.name, INFO.name, 15.0)


def test_a_registered_depth_makes_it_a_depth_camera() -> None:
    depth = Topic("/head/aligned_depth_to_color/image_raw", IMAGE, rate_hz=15.0, frame="other", holds="depth")
    assert f"  kinect: {{topic: {COLOR.name}, " in propose([*WHOLE, COLOR, INFO, depth]).text
    apart = Topic("/head/depth/image_raw", IMAGE, rate_hz=15.0, frame="depth_optical", holds="depth")
    proposal = propose([*WHOLE, COLOR, INFO, apart])
    assert f"  camera: {{topic: {COLOR.name}, " in proposal.text
    assert f"camera: {apart.name} is not mapped: it may not be registered to the pictures." in proposal.remarks


def test_what_a_camera_lacks_is_said() -> None:
    proposal = propose([*WHOLE, COLOR], {"base_link": True, "rplidar_link": True})
    assert f"camera: {COLOR.name} has no CameraInfo: measure its horizontal_fov_deg." in proposal.missing
    assert any("the model has no link 'camera_optical', which its pictures name" in s for s in proposal.missing)
    assert "horizontal_fov_deg: 60" in proposal.text


def test_the_likeliest_camera_of_several_is_taken() -> None:
    other = Topic("/rear/color/image_raw", IMAGE, rate_hz=15.0, frame="rear_optical", holds="color")
    proposal = propose([*WHOLE, COLOR, INFO, other])
    assert f"camera: {COLOR.name} was chosen; there are also {other.name}." in proposal.remarks
