"""The content of records in ROS's own types, as another program would read it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.logs.ros import typestore
from app.logs.ros.converters import Options, converter
from app.logs.ros.record import Record
from app.logs.stamps import to_ns
from app.messages import Image, JointState, Landmark, Landmarks, LaserScan, LogLine, Odometry, PointCloud, Twist
from tests.logs.ros.messages import message_classes, sequences

STAMP = 1_790_000_000.25
FISHEYE = FisheyeModel.from_fov(64, 48, math.pi, math.pi)
POSE = Pose3.from_translation_rpy((0.1, 0.2, 1.0), (0.0, 0.0, math.pi / 2))


def records_of(message: Any, rate_hz: float | None = None) -> dict[str, Any]:
    """The message's records by topic, decoded by rosbags."""
    made = converter("channel", type(message), Options(rate_hz)).encode(message, to_ns(message.stamp))
    return {record.topic: decoded(record) for record in made}


def decoded(record: Record) -> Any:
    """The rosbags object of a record."""
    return typestore.deserialise(record.type, record.data)


def transform(tf: Any) -> tuple[str, str, list[float], list[float]]:
    """Parent, child, translation and quaternion (x, y, z, w) of the one transform in ``tf``."""
    (one,) = tf.transforms
    assert one.header.stamp.sec == int(STAMP)
    assert one.header.stamp.nanosec == 250_000_000
    t, q = one.transform.translation, one.transform.rotation
    return one.header.frame_id, one.child_frame_id, [t.x, t.y, t.z], [q.x, q.y, q.z, q.w]


@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
@settings(max_examples=30, suppress_health_check=[HealthCheck.differing_executors])
@given(data=st.data())
def test_bytes_are_those_that_rosbags_writes(cls: type[Any], data: st.DataObject) -> None:
    codec = converter("channel", cls)
    for message in data.draw(sequences(cls)):
        for record in codec.encode(message, to_ns(message.stamp)):
            again = typestore.store().serialize_cdr(decoded(record), record.type, little_endian=True)
            assert bytes(again) == record.data, record.type


@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
def test_definitions_keep_to_the_names_that_ros_allows(cls: type[Any]) -> None:
    for topic in converter("channel", cls).topics:
        text = typestore.definition(topic.type)
        for line in text.splitlines():
            if line.startswith(("=", "MSG: ")):
                continue
            assert re.fullmatch(r"[\w/]+(\[\d*\])? ([a-z](_?[a-z0-9])*|[A-Z][A-Z0-9_]*=-?\w+)", line.strip()), line


def image(color: np.ndarray[Any, Any], depth: bool = True) -> Image:
    height, width = color.shape[:2]
    metres = np.arange(height * width, dtype=np.uint16).reshape(height, width) if depth else None
    return Image(STAMP, "eye", color, metres, CameraModel(width, height, 500.0, 510.0, 31.5, 23.5), POSE)


def test_an_image_is_jpeg_in_its_true_colours_with_raw_depth_and_its_camera() -> None:
    color = np.zeros((48, 64, 3), np.uint8)
    color[..., 0] = 255
    records = records_of(image(color))
    jpeg = records["/channel/color/compressed"]
    assert (jpeg.format, jpeg.header.frame_id) == ("jpeg", "eye")
    blue, green, red = np.asarray(cv2.imdecode(jpeg.data, cv2.IMREAD_COLOR))[24, 32]
    assert red > 250
    assert max(blue, green) < 5
    depth = records["/channel/depth"]
    assert (depth.encoding, depth.height, depth.width, depth.step, depth.is_bigendian) == ("16UC1", 48, 64, 128, 0)
    assert depth.data.view(np.uint16).tolist() == list(range(48 * 64))
    info = records["/channel/camera_info"]
    assert info.k.reshape(3, 3).tolist() == [[500.0, 0.0, 31.5], [0.0, 510.0, 23.5], [0.0, 0.0, 1.0]]
    assert info.p.reshape(3, 4)[:, :3].tolist() == info.k.reshape(3, 3).tolist()
    assert (info.height, info.width, info.distortion_model, info.header.frame_id) == (48, 64, "plumb_bob", "eye")
    parent, child, t, q = transform(records["/tf"])
    assert (parent, child, t) == ("base_link", "eye", [0.1, 0.2, 1.0])
    assert q == pytest.approx([0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)])


def test_a_fisheye_is_an_equidistant_camera_without_further_terms() -> None:
    fisheye = replace(image(np.zeros((48, 64, 3), np.uint8), depth=False), camera=FISHEYE)
    records = records_of(fisheye)
    info = records["/channel/camera_info"]
    assert (info.distortion_model, info.d.tolist()) == ("equidistant", [0.0] * 4)
    assert info.k.reshape(3, 3).tolist() == [[FISHEYE.fx, 0.0, 31.5], [0.0, FISHEYE.fy, 23.5], [0.0, 0.0, 1.0]]
    assert (info.height, info.width) == (48, 64)
    assert records["/channel/info"].camera.theta_max == math.pi / 2
    parent, child, t, _ = transform(records["/tf"])
    assert (parent, child, t) == ("base_link", "eye", [0.1, 0.2, 1.0])


def test_another_lens_on_the_same_channel_is_refused() -> None:
    codec = converter("channel", Image)
    pinhole = image(np.zeros((48, 64, 3), np.uint8))
    codec.encode(pinhole, 0)
    with pytest.raises(ValueError, match="FisheyeModel among those of a CameraModel"):
        codec.encode(replace(pinhole, camera=FISHEYE), 1)
    codec.encode(pinhole, 2)


def test_a_camera_without_depth_writes_none() -> None:
    assert "/channel/depth" not in records_of(image(np.zeros((4, 4, 3), np.uint8), depth=False))


def test_the_quality_of_jpeg_is_the_one_asked_for() -> None:
    color = np.random.default_rng(1).integers(0, 255, (48, 64, 3)).astype(np.uint8)
    sizes = [
        len(converter("c", Image, Options(jpeg_quality=quality)).encode(image(color), 0)[0].data)
        for quality in (50, 90, 98)
    ]
    assert sizes == sorted(sizes)
    assert sizes[0] < 0.6 * sizes[2]


SCAN = LaserScan(
    STAMP, "laser", np.array([1.0, 2.0, np.inf, 0.01, 4.0], np.float32), np.arange(5, dtype=np.float32),
    -math.pi / 2, math.pi / 4, 0.05, 10.0, 0.02, POSE,
)  # fmt: skip


def test_a_scan_is_a_laser_scan_and_its_hits_are_points_in_the_lasers_frame() -> None:
    records = records_of(SCAN, rate_hz=40)
    scan = records["/channel"]
    assert scan.header.frame_id == "laser"
    assert (scan.scan_time, scan.time_increment) == pytest.approx((0.025, 0.005))
    assert (scan.angle_min, scan.angle_max) == pytest.approx((-math.pi / 2, math.pi / 2))
    assert np.array_equal(scan.ranges, SCAN.ranges)
    assert np.array_equal(scan.intensities, SCAN.intensities)
    points = records["/channel/points"]
    assert [(f.name, f.offset, f.datatype, f.count) for f in points.fields] == [
        ("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1)
    ]  # fmt: skip
    assert (points.height, points.width, points.point_step, points.row_step) == (1, 3, 12, 36)
    assert points.header.frame_id == "laser"
    half = math.sqrt(2.0)
    assert points.data.view(np.float32).tolist() == pytest.approx([0, -1, 0, half, -half, 0, 0, 4, 0], abs=1e-6)
    assert transform(records["/tf"])[:2] == ("base_link", "laser")


def test_points_are_drawn_ten_times_a_second_and_the_transform_once_or_when_it_moves() -> None:
    codec = converter("channel", LaserScan)
    written: list[list[str]] = []
    for i in range(80):
        scan = replace(SCAN, stamp=STAMP + i / 40, X_BL=POSE if i < 60 else Pose3.identity())
        written.append([record.topic for record in codec.encode(scan, to_ns(scan.stamp))])
    assert [i for i, topics in enumerate(written) if "/channel/points" in topics] == list(range(0, 80, 4))
    assert [i for i, topics in enumerate(written) if "/tf" in topics] == [0, 38, 60]
    assert all(topics[0] == "/channel" and topics[-1] == "/channel/info" for topics in written)


def test_after_a_clock_that_went_back_points_and_transform_are_drawn_at_once() -> None:
    codec = converter("channel", LaserScan)
    codec.encode(SCAN, to_ns(STAMP))
    assert {"/channel/points", "/tf"} <= {record.topic for record in codec.encode(SCAN, to_ns(STAMP - 1000))}


def test_odometry_is_pose_twist_and_transform() -> None:
    records = records_of(Odometry(STAMP, Pose2(1.0, 2.0, math.pi / 2), 0.3, -0.2, 0.15))
    odometry = records["/channel"]
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_link")
    assert (odometry.pose.pose.position.x, odometry.pose.pose.position.y) == (1.0, 2.0)
    assert odometry.pose.pose.orientation.z == pytest.approx(math.sqrt(0.5))
    velocity = odometry.twist.twist
    assert (velocity.linear.x, velocity.linear.y, velocity.angular.z) == (0.3, 0.15, -0.2)
    parent, child, t, q = transform(records["/tf"])
    assert (parent, child, t) == ("odom", "base_link", [1.0, 2.0, 0.0])
    assert q == pytest.approx([0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)])


def test_small_messages_are_what_ros_calls_them() -> None:
    twist = records_of(Twist(STAMP, 0.4, 0.1, -0.2))["/channel"]
    assert (twist.header.frame_id, twist.twist.linear.x, twist.twist.angular.z) == ("base_link", 0.4, 0.1)
    assert twist.twist.linear.y == -0.2
    joints = records_of(JointState(STAMP, ("pan", "tilt"), (0.5, -0.5)))["/channel"]
    assert (joints.name, joints.position.tolist(), len(joints.velocity)) == (["pan", "tilt"], [0.5, -0.5], 0)
    assert len(joints.effort) == 0
    felt = records_of(JointState(STAMP, ("pan", "tilt"), (0.5, -0.5), (1.5, 2.0)))["/channel"]
    assert (felt.position.tolist(), felt.effort.tolist()) == ([0.5, -0.5], [1.5, 2.0])
    line = records_of(LogLine(STAMP, 30, "hbba.guard", "no command"))["/channel"]
    assert (line.level, line.name, line.msg) == (line.WARN, "hbba.guard", "no command")


def test_landmarks_are_drawn_again_when_one_is_new_or_elsewhere_but_not_at_every_sighting() -> None:
    codec = converter("channel", Landmarks)
    lamp = Landmark("lamp", (1.0, 2.0, 0.5), 0.01, 3, STAMP, STAMP)
    lists = [
        (lamp,),
        (replace(lamp, p_FQ=(1.002, 2.0, 0.5), sightings=4),),
        (replace(lamp, p_FQ=(1.2, 2.0, 0.5)),),
        (replace(lamp, p_FQ=(1.2, 2.0, 0.5)), replace(lamp, text="door \udcff")),
    ]
    written = [codec.encode(Landmarks(STAMP, landmarks), to_ns(STAMP)) for landmarks in lists]
    assert [[record.topic for record in records] for records in written] == [
        ["/channel/markers", "/channel"], ["/channel"], ["/channel/markers", "/channel"],
        ["/channel/markers", "/channel"],
    ]  # fmt: skip
    clear, *markers = decoded(written[3][0]).markers
    assert clear.action == clear.DELETEALL
    assert [(m.id, m.type, m.action, m.text) for m in markers] == [
        (0, clear.SPHERE, 0, ""), (1, clear.TEXT_VIEW_FACING, 0, "lamp"),
        (2, clear.SPHERE, 0, ""), (3, clear.TEXT_VIEW_FACING, 0, "door ?"),
    ]  # fmt: skip
    assert {m.header.frame_id for m in markers} == {"odom"}
    assert (markers[0].pose.position.x, markers[0].scale.x) == (1.2, 0.1)
    placed = codec.encode(Landmarks(STAMP, lists[3], "map"), to_ns(STAMP))
    assert {m.header.frame_id for m in decoded(placed[0]).markers} == {"map"}


def test_half_a_character_in_a_log_line_does_not_end_a_recording() -> None:
    line = records_of(LogLine(STAMP, 20, "hbba", "file \udcff"))["/channel"]
    assert line.msg == "file ?"


def test_a_cloud_has_its_colours_as_pcl_packs_them() -> None:
    points = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], np.float32)
    cloud = PointCloud(STAMP, points, np.array([[255, 0, 1], [2, 3, 4]], np.uint8), Pose2())
    record = records_of(cloud)["/channel"]
    assert [(f.name, f.offset) for f in record.fields] == [("x", 0), ("y", 4), ("z", 8), ("rgb", 12)]
    rows = record.data.view(np.uint32).reshape(2, 4)
    assert [hex(value) for value in rows[:, 3]] == ["0xff0001", "0x20304"]
    assert np.array_equal(rows[:, :3].view(np.float32), points)
    assert record.header.frame_id == "base_link"
