"""Bags written by other tools: every message lands on its channel, placed and paired as it was captured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer

from app.logs.log import Log, Logged
from app.logs.open import open_log
from app.messages import Image, JointState, LaserScan, Odometry
from tests.logs.importers import drive
from tests.logs.importers.bags import ROS1, Sent, header, made, write_ros1, write_ros2_mcap, write_ros2_sqlite

Write = Callable[[Path, list[Sent]], Path]
Bag = Callable[..., Path]
WRITERS: dict[str, Write] = {
    "ROS 1": lambda folder, sent: write_ros1(folder / "run.bag", sent),
    "ROS 1, lz4, another name": lambda folder, sent: write_ros1(folder / "run.bag", sent, "lz4").rename(folder / "run"),
    "ROS 2, SQLite": lambda folder, sent: write_ros2_sqlite(folder / "run", sent),
    "ROS 2, SQLite file": lambda folder, sent: write_ros2_sqlite(folder / "run", sent) / "run_0.db3",
    "ROS 2, MCAP": lambda folder, sent: write_ros2_mcap(folder / "run.mcap", sent),
}


@pytest.fixture(scope="module", params=list(WRITERS.values()), ids=list(WRITERS))
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Bag:
    """Each kind of bag in turn: called with the parameters of the drive, it gives the bag's path. Tests must not change
    it."""
    made: dict[str, Path] = {}

    def of(**options: Any) -> Path:
        key = repr(options)
        if key not in made:
            made[key] = request.param(tmp_path_factory.mktemp("bag"), drive.drive(**options))
        return made[key]

    return of


def everything(log: Log, **options: object) -> list[Logged]:
    messages = list(log.messages(**options))  # type: ignore[arg-type]
    log.close()
    return messages


def on(channel: str, messages: list[Logged]) -> list[Logged]:
    return [message for message in messages if message.channel == channel]


def test_topics_find_their_channels(bag: Bag) -> None:
    log = open_log(bag())
    info = log.info
    assert {name: (channel.message_type, channel.count) for name, channel in info.channels.items()} == {
        "kinect": (Image, 40),
        "scan": (LaserScan, 80),
        "odometry": (Odometry, 80),
        "joints": (JointState, 80),
    }
    assert info.channels["scan"].rate_hz == pytest.approx(20, rel=0.05)
    assert set(info.ignored) == {"/battery", "/cmd_vel"}
    assert "BatteryState" in info.ignored["/battery"]
    assert info.notes == ()
    assert log.manifest.facts == {
        "stream.kinect": "kinect",
        "stream.hokuyo": "scan",
        "stream.odometry": "odometry",
        "stream.joints": "joints",
    }
    messages = everything(log)
    assert {name: len(on(name, messages)) for name in info.channels} == {
        "kinect": 40, "scan": 80, "odometry": 80, "joints": 80,
    }  # fmt: skip
    assert [message.at for message in messages] == sorted(message.at for message in messages)
    assert info.begin <= messages[0].at
    assert messages[-1].at <= info.end


def test_pictures_have_their_depth_and_the_cameras_pose_at_their_stamp(bag: Bag) -> None:
    images = on("kinect", everything(open_log(bag())))
    for i, logged in enumerate(images):
        image = logged.message
        assert image.stamp == pytest.approx(drive.ns(0.1 * i + 0.05) / 1e9, abs=1e-6)
        assert logged.at == pytest.approx(image.stamp + 0.02, abs=1e-6)
        assert image.frame == drive.OPTICAL
        np.testing.assert_array_equal(image.color, drive.color_at(i))
        np.testing.assert_array_equal(image.depth, drive.depth_at(i))
        assert (image.camera.fx, image.camera.cx, image.camera.cy) == (525.0, 159.5, 119.5)
        assert not image.color.flags.writeable
        assert not image.depth.flags.writeable
        truth = drive.camera_at(image.stamp)
        # Interpolated between transforms 40 ms apart; the last picture comes after the last of them.
        np.testing.assert_allclose(image.X_BC.rotation, truth.rotation, atol=1e-6 if i < 39 else 0.02)
        np.testing.assert_allclose(image.X_BC.translation, truth.translation, atol=1e-4 if i < 39 else 0.02)


def test_scans_odometry_and_joints_say_what_was_measured(bag: Bag) -> None:
    messages = everything(open_log(bag()))
    for i, logged in enumerate(on("scan", messages)):
        scan = logged.message
        np.testing.assert_array_equal(scan.ranges, np.array([0.5, 1.5, np.inf, 5.0, np.inf, 0.0, 0.02], np.float32))
        np.testing.assert_array_equal(scan.intensities, np.arange(7, dtype=np.float32) + i)
        assert (scan.angle_min, scan.angle_increment, scan.range_max) == (-1.5, 0.5, 10.0)
        assert scan.duration_s == pytest.approx(0.006)
        np.testing.assert_allclose(scan.X_BL.rotation, drive.X_BL.rotation, atol=1e-12)
        np.testing.assert_allclose(scan.X_BL.translation, drive.X_BL.translation, atol=1e-12)
    for logged in on("odometry", messages):
        truth = drive.base_at(logged.message.stamp)
        X_OB = logged.message.X_OB
        assert (X_OB.x, X_OB.y, X_OB.theta) == pytest.approx((truth.x, truth.y, truth.theta), abs=1e-6)
        assert (logged.message.linear_mps, logged.message.angular_radps) == (drive.SPEED, drive.TURN)
    for logged in on("joints", messages):
        assert logged.message.names == ("neck_pan",)
        assert logged.message.positions[0] == pytest.approx(
            drive.PAN * (logged.message.stamp - drive.BEGIN / 1e9), abs=1e-6
        )


def test_reading_may_begin_anywhere(bag: Bag) -> None:
    path = bag()
    whole = everything(open_log(path))
    begin = drive.ns(2.345) / 1e9
    part = everything(open_log(path), begin=begin)
    later = [message for message in whole if message.at >= begin]
    assert [(m.at, m.channel) for m in part] == [(m.at, m.channel) for m in later]
    for one, other in zip(on("kinect", part), on("kinect", later), strict=True):
        np.testing.assert_array_equal(one.message.depth, other.message.depth)
        np.testing.assert_array_equal(one.message.X_BC.rotation, other.message.X_BC.rotation)
    assert {m.channel for m in everything(open_log(path), begin=begin, channels={"scan"})} == {"scan"}
    assert everything(open_log(path), begin=drive.ns(60) / 1e9) == []


def test_without_odometry_tf_says_where_the_base_is(bag: Bag) -> None:
    log = open_log(bag(odometry=False))
    assert log.info.channels["odometry"].message_type is Odometry
    found = on("odometry", everything(log))
    assert len(found) == 100
    for logged in found:
        truth = drive.base_at(logged.message.stamp)
        X_OB = logged.message.X_OB
        assert (X_OB.x, X_OB.y, X_OB.theta) == pytest.approx((truth.x, truth.y, truth.theta), abs=1e-6)
    for logged in found[1:]:
        assert logged.message.linear_mps == pytest.approx(drive.SPEED, rel=1e-3)
        assert logged.message.angular_radps == pytest.approx(drive.TURN, rel=1e-3)
        assert logged.message.lateral_mps == pytest.approx(0.0, abs=1e-3), "on an arc it does not move sideways"


def test_compressed_colour_and_depth_in_metres(bag: Bag) -> None:
    log = open_log(bag(compressed=True, metres=True))
    images = on("kinect", everything(log))
    assert len(images) == 40
    for i, logged in enumerate(images):
        assert np.abs(logged.message.color.astype(int) - drive.color_at(i)).mean() < 3
        np.testing.assert_array_equal(logged.message.depth, drive.depth_at(i))


def test_packed_by_bzip2(tmp_path: Path) -> None:
    sent = [message for message in drive.drive(compressed=True) if "depth" not in message.topic]
    log = open_log(write_ros1(tmp_path / "run.bag", sent, "bz2"))
    messages = everything(log)
    assert len(on("kinect", messages)) == 40
    assert on("kinect", messages)[0].message.depth is None
    assert len(on("scan", messages)) == 80


def test_unknown_types_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    kind = "sensor_msgs/msg/JointState"
    (first,) = [m for m in drive.drive() if m.topic == "/joint_states"][:1]
    with Writer(path) as writer:
        odd = writer.add_connection("/odd", "strange_msgs/msg/Odd", msgdef="this is [no definition", md5sum="0" * 32)
        joints = writer.add_connection(first.topic, kind, typestore=ROS1)
        writer.write(odd, first.at, b"1234")
        writer.write(joints, first.at, bytes(ROS1.serialize_ros1(made(ROS1, kind, first.fields), kind)))
    log = open_log(path)
    assert [message.channel for message in log.messages()] == ["joints"]
    assert log.info.ignored == {"/odd": "strange_msgs/msg/Odd: no message of this program says this"}
    log.close()


def test_the_first_tf_of_ros_1(tmp_path: Path) -> None:
    """tf/tfMessage, before there was tf2: standing frames are said again and again on /tf."""
    sent = [
        replace(m, topic="/tf", type="tf/msg/tfMessage") if "tf" in m.topic else m for m in drive.drive(compressed=True)
    ]
    standing = next(m for m in sent if m.topic == "/tf")
    for i in range(1, 40):
        heads = [
            {**t, "header": header(drive.ns(0.1 * i), t["header"]["frame_id"])} for t in standing.fields["transforms"]
        ]
        sent.append(replace(standing, at=drive.ns(0.1 * i + 0.001), fields={"transforms": heads}))
    log = open_log(write_ros1(tmp_path / "run.bag", sorted(sent, key=lambda m: m.at)))
    assert log.info.notes == ()
    for logged in log.messages(channels={"kinect"}):
        truth = drive.camera_at(logged.message.stamp)
        np.testing.assert_allclose(logged.message.X_BC.rotation, truth.rotation, atol=0.02)
    log.close()
