"""A body's mistakes name file, line, key and what is allowed; a body that is right is described whole."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.messages import BatteryState, GamepadState, JointState, LaserScan, LinkStatus, Odometry
from app.robots.drivers.config import DriversConfig, load_drivers_config
from app.robots.drivers.link import DriversLink
from app.robots.factory import create_link, load_body
from tests.robots.drivers.parts import SHIPPED


def changed(folder: Path, before: str, after: str) -> Path:
    """The body as shipped with one passage changed."""
    text = SHIPPED.read_text("utf-8")
    assert before in text
    text = text.replace(before, after, 1)
    for name in ("serial_base.urdf", "../serial_base.yaml"):
        text = text.replace(f": {name}\n", f": {(SHIPPED.parent / name).resolve()}\n")
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("port: tcp://192.168.0.10:10940", "port: tcp://hokuyo:10940", "hokuyo: "),
        ("baud: 115200", "baud: 115201", "base: baud 115201 is none that Linux knows"),
        ("timeout_s: 0.2 ", "timeout_s: 2 ", "base.timeout_s: should be less than or equal to 1"),
        ("dead_man: BTN_TL", "dead_man: BTN_LT", "gamepad.dead_man: there is no button 'BTN_LT'; did you mean"),
        ("stop: BTN_EAST", "stop: BTN_TL", "gamepad: stop and dead_man are both BTN_TL"),
        ("linear: ABS_Y", "linear: Y", "gamepad.linear: there is no axis 'Y'"),
        ("link: hokuyo_link", "link: laser", "hokuyo.link: the model"),
        ("link: hokuyo_link", "link: left_wheel", "hokuyo.link: the joint 'left_wheel_joint' of the model moves"),
        ("[left_wheel_joint,", "[left_joint,", "base.wheel_joints: the model"),
        ("[odometry, hokuyo]", "[odometry, kinect]", "required_sensors: there is no 'kinect'; "),
        ("[odometry, hokuyo]", "[hokuyo]", "required_sensors must have odometry"),
        (
            "rate_hz: 40",
            "characters: 2\n  intensities: true",
            "intensities come with 3 characters alone",
        ),
        ("rate_hz: 40", "scans: 40", "hokuyo.scans: unknown key; allowed: baud, characters,"),
        ("height_m: 0.25", "actuators: {arm: {joints: [left_wheel_joint]}}", "no motors but its wheels"),
        ("angular_radps: 1.5", "angular_radps: 1.5\n  lateral_mps: 0.2", "does not move sideways"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, before: str, after: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load_drivers_config(changed(tmp_path, before, after))
    assert "robot.yaml:" in str(refused.value)
    assert said in str(refused.value)


def test_the_body_as_shipped_is_described_whole() -> None:
    config = load_body(SHIPPED)
    assert isinstance(config, DriversConfig)
    assert pickle.loads(pickle.dumps(config)) == config  # it goes to another process
    link = create_link(config, 0.0)
    assert isinstance(link, DriversLink)
    robot = link.description
    assert {name: stream.message_type for name, stream in robot.streams.items()} == {
        "odometry": Odometry,
        "joints": JointState,
        "status": LinkStatus,
        "battery": BatteryState,
        "hokuyo": LaserScan,
        "gamepad": GamepadState,
    }
    assert (robot.simulated, robot.restartable, robot.loudspeaker) == (False, True, False)
    assert robot.limits.linear_mps == 0.40
