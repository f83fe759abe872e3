"""The robot's configuration file and what is said about a wrong one."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from app.errors import ConfigError
from app.messages import GroundTruth, Image, LaserScan
from app.robots.config import RobotConfig, load_robot_config
from app.robots.factory import create_link


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
        link.demand("nose", True)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("base: {left_wheel_joint: leg}", "no moving joint 'leg'"),
        ("streams: {hokuyo: {link: nose}}", "no link 'nose'"),
    ],
)
def test_names_the_model_has_not_are_refused(tmp_path: Path, robot: RobotConfig, change: str, complaint: str) -> None:
    path = write(tmp_path, f"model: {robot.model}\nworld: {robot.world}\n{change}\n")
    with pytest.raises(ConfigError, match=complaint):
        create_link(load_robot_config(path), 0.0)
