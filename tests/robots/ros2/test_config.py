"""A mapping's mistakes name file, line, key and what is allowed."""

from __future__ import annotations

import importlib.util
import pickle
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.base.yaml_source import load_yaml
from app.link import LinkFailed
from app.logs.ros.live.graph import MISSING, environment
from app.robots.factory import load_body
from app.robots.ros2.config import Ros2Config, load_ros2_config
from app.robots.ros2.link import Ros2Link, describe
from tests.robots.ros2.robot import MAPPING


def changed(folder: Path, before: str, after: str) -> Path:
    """The mapping as shipped with one passage changed."""
    text = MAPPING.read_text("utf-8")
    assert before in text
    text = text.replace(before, after, 1)
    for name in ("turtlebot4.urdf", "../turtlebot4.yaml"):
        text = text.replace(f": {name}\n", f": {(MAPPING.parent / name).resolve()}\n")
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("topic: odom,", "topic: od om,", "streams.odometry.topic: a topic's name is of letters, digits and _"),
        (
            "TwistStamped",
            "Wrench",
            "base.type: should be 'geometry_msgs/msg/Twist' or 'geometry_msgs/msg/TwistStamped'",
        ),
        ("  watchdog_s: 0.5", "", "base.watchdog_s: is missing"),
        (
            "watchdog_s: 0.5",
            "watchdog_s: 0.01",
            "base: watchdog_s 0.01 is no longer than the time between two commands",
        ),
        ("clock: header", "clock: wall", "graph.clock: should be 'header', 'sim' or 'arrival', not 'wall'"),
        ("domain: null", "domain: 300", "graph.domain: should be less than or equal to 232, not 300"),
        ("domain: null", "rosbridge: robot:9090", "graph.rosbridge: 'robot:9090' is no ws://HOST:PORT or wss://"),
        ("domain: null", "rosbridge: ws://robot", "graph.rosbridge: 'ws://robot' is no ws://HOST:PORT or wss://"),
        ("domain: null", "rosbridge: ws://robot:99999", "graph.rosbridge: 'ws://robot:99999' is no ws://HOST:PORT"),
        ("domain: null", "rosbridge: ws://a..b:9090", "graph.rosbridge: 'ws://a..b:9090' is no ws://HOST:PORT"),
        ("domain: null", "rosbridge: ws://a:b@robot:9090", "graph.rosbridge: 'ws://a:b@robot:9090' is no ws://"),
        (
            "domain: null",
            "domain: 3\n  rosbridge: ws://robot:9090",
            "graph: domain and discovery are of ROS 2's own middleware, which rosbridge takes the place of",
        ),
        ("link: rplidar_link", "link: laser", "streams.hokuyo.link: the model"),
        ("link: rplidar_link", "link: left_wheel", "streams.hokuyo.link: the joint 'left_wheel_joint' of the model"),
        (
            "[odometry]",
            "[odometry, kinect]",
            "required_sensors: 'kinect' has no topic; allowed: battery, camera, hokuyo, joints",
        ),
        ("[odometry]", "[hokuyo]", "required_sensors must have odometry"),
        (
            "  hokuyo:",
            "  lidar:",
            "streams.lidar: unknown key; allowed: battery, camera, hokuyo, imu, joints, kinect, odometry",
        ),
        (
            "link: oakd_rgb_camera_optical_frame",
            "link: oakd",
            "streams.camera.link: the model",
        ),
        (
            "height_m: 0.35",
            "actuators: {head: {joints: [left_wheel_joint]}}",
            "actuators: head has no topic or action in joint_commands",
        ),
        (
            "height_m: 0.35",
            "actuators: {head: {joints: [left_wheel_joint], stop: yield}}",
            "head: over ROS 2 joints take positions alone: stale and stop are hold",
        ),
        (
            "height_m: 0.35",
            "actuators: {head: {joints: [left_wheel_joint], compliant: true}}",
            "head: over ROS 2 joints take positions alone: no compliance, and no contact",
        ),
        (
            "  battery: {",
            "  imu: {topic: imu, link: left_wheel}\n  battery: {",
            "moves 'left_wheel'; the inertial sensor must be fixed to the base",
        ),
        (
            "height_m: 0.35",
            "joint_commands: {head: {topic: head, action: head}}",
            "joint_commands.head: set-points go to a topic or to an action: name one of them",
        ),
        (
            "height_m: 0.35",
            "joint_commands: {head: {action: head, type: std_msgs/msg/Float64MultiArray}}",
            "joint_commands.head: type is a topic's; the action head is a control_msgs/action/FollowJointTrajectory",
        ),
        (
            "rate_hz: 10, link: oakd",
            "turned_deg: 45, link: oakd",
            "streams.camera.turned_deg: should be 0, 90, 180 or 270",
        ),
        ("height_m: 0.35", "joint_commands: {head: {topic: head}}", "joint_commands: there is no group 'head'"),
        (
            "height_m: 0.35",
            "joint_commands: {head: {topic: head, type: std_msgs/msg/String}}",
            "joint_commands.head.type: should be 'trajectory_msgs/msg/JointTrajectory' or",
        ),
    ],
)
def test_a_mistake_has_its_place(tmp_path: Path, before: str, after: str, said: str) -> None:
    path = changed(tmp_path, before, after)
    with pytest.raises(ConfigError) as refused:
        load_body(path)
    assert said in refused.value.message
    assert refused.value.file == str(path)
    assert refused.value.line > 0


def test_a_mistake_of_the_robot_has_the_mappings_place(tmp_path: Path) -> None:
    path = changed(tmp_path, "TurtleBot 4 over", "TurtleBot 4 over")
    mistake = load_ros2_config(path).mistake("is of another type", "streams", "hokuyo", "topic")
    line = 1 + next(n for n, text in enumerate(path.read_text("utf-8").splitlines()) if "hokuyo:" in text)
    assert str(mistake) == f"{path}:{line}: streams.hokuyo.topic: is of another type"
    name = 1 + next(n for n, text in enumerate(path.read_text("utf-8").splitlines()) if text.startswith("name:"))
    assert str(pickle.loads(pickle.dumps(load_ros2_config(path))).mistake("x", "name")) == f"{path}:{name}: name: x"


def test_topics_are_in_the_namespace_unless_they_begin_at_the_root(tmp_path: Path) -> None:
    config = load_ros2_config(changed(tmp_path, 'namespace: ""', "namespace: robot1"))
    assert config.full_name("odom") == "/robot1/odom"
    assert config.full_name("/tf") == "/tf"
    assert load_ros2_config(MAPPING).full_name("odom") == "/odom"


def test_the_body_is_described_by_its_mapping() -> None:
    body = load_body(MAPPING)
    assert isinstance(body, Ros2Config)
    described = describe(body)
    assert {name: stream.rate_hz for name, stream in described.streams.items()} == {
        "odometry": 20, "joints": 20, "hokuyo": 7.5, "battery": 0.2, "camera": 10, "status": 20,
    }  # fmt: skip
    assert (described.simulated, described.restartable, described.limits.linear_mps) == (False, True, 0.3)


def test_how_far_the_process_looks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FASTDDS_BUILTIN_TRANSPORTS", raising=False)
    assert environment(load_ros2_config(MAPPING).graph.discovery) == {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    monkeypatch.setenv("FASTDDS_BUILTIN_TRANSPORTS", "LARGE_DATA")
    local = load_ros2_config(changed(tmp_path, "discovery: environment", "discovery: localhost"))
    assert environment(local.graph.discovery) == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def test_over_rosbridge_joints_move_by_topics_alone(tmp_path: Path) -> None:
    groups = "actuators: {head: {joints: [left_wheel_joint]}}\njoint_commands:\n  head:\n    action: head_controller\n"
    path = changed(tmp_path, "height_m: 0.35", groups)
    load_ros2_config(path)
    path.write_text(path.read_text("utf-8").replace("domain: null", "rosbridge: wss://robot:9090/bridge"), "utf-8")
    line = 1 + path.read_text("utf-8").splitlines().index("    action: head_controller")
    with pytest.raises(ConfigError, match=f":{line}: joint_commands.head.action: over rosbridge set-points go to"):
        load_ros2_config(path)


@pytest.mark.blocking(reason="reads the mapping")
@pytest.mark.skipif(importlib.util.find_spec("rclpy") is not None, reason="ROS 2 is installed")
async def test_without_ros_the_remedy_is_one_sentence() -> None:
    with pytest.raises(LinkFailed) as refused:
        await Ros2Link(load_ros2_config(MAPPING), 0.0).start()
    assert str(refused.value) == MISSING


def test_the_topics_of_a_camera(tmp_path: Path) -> None:
    config = load_ros2_config(MAPPING)
    assert config.readings["camera"] == ("/oakd/rgb/preview/image_raw", "sensor_msgs/msg/Image")
    assert config.readings["camera.info"] == ("/oakd/rgb/preview/camera_info", "sensor_msgs/msg/CameraInfo")
    packed = load_ros2_config(changed(tmp_path, "image_raw, rate_hz: 10", "image_rect/compressed, rate_hz: 10"))
    assert packed.readings["camera"][1] == "sensor_msgs/msg/CompressedImage"
    assert packed.readings["camera.info"][0] == "/oakd/rgb/preview/camera_info"
    assert packed.streams.camera is not None
    assert packed.streams.camera.is_rectified
    wide = load_ros2_config(changed(tmp_path, "rate_hz: 10, link: oakd", "horizontal_fov_deg: 70, link: oakd"))
    assert "camera.info" not in wide.readings


def test_a_camera_that_joints_move_needs_them(tmp_path: Path) -> None:
    path = changed(tmp_path, "link: oakd_rgb_camera_optical_frame", "link: left_wheel")
    load_ros2_config(path)
    path.write_text(path.read_text("utf-8").replace("  joints: {topic: joint_states, rate_hz: 20}\n", ""), "utf-8")
    with pytest.raises(ConfigError, match=r"'left_wheel_joint' of the model moves 'left_wheel'.*map joints"):
        load_ros2_config(path)


def test_the_stretch_has_the_joints_that_its_program_turns() -> None:
    program = load_yaml(paths.config_dir() / "stretch.yaml").data
    body = load_body(paths.config_dir() / "robots" / "stretch.yaml")
    assert isinstance(body, Ros2Config)
    teleop = program["modules"]["HeadTeleop"]["settings"]
    joints = [joint.name for joint in body.groups["head"].joints]
    assert [teleop["pan"], teleop["tilt"]] == joints
    assert body.joint_commands["head"].hz == 4.0
    assert describe(body).streams["imu"].rate_hz == 30
