"""Every encoding of pictures and depths, and what drivers write into the other messages."""

from __future__ import annotations

import math
import struct
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.logs.importers import ros_messages as ros
from tests.logs.importers.bags import ROS1, ROS2, header, made
from tests.logs.importers.drive import image

STAMP = 1_700_000_000_123_456_789


def picture(encoding: str, pixels: NDArray[Any], **fields: Any) -> Any:
    return made(ROS2, "sensor_msgs/msg/Image", {"header": header(STAMP, "/cam"), **image(encoding, pixels), **fields})


def colors() -> NDArray[np.uint8]:
    """(6, 8, 3) RGB, all different."""
    return np.arange(6 * 8 * 3, dtype=np.uint8).reshape(6, 8, 3)


@pytest.mark.parametrize(
    ("encoding", "order"),
    [("rgb8", [0, 1, 2]), ("bgr8", [2, 1, 0]), ("8UC3", [2, 1, 0]), ("rgba8", [0, 1, 2, 0]), ("bgra8", [2, 1, 0, 0])],
)
def test_colours_in_any_order(encoding: str, order: list[int]) -> None:
    message = picture(encoding, colors()[..., order])
    np.testing.assert_array_equal(ros.color_image(message), colors())
    assert ros.encoding_of(message) == "color"


def test_grey_becomes_three_equal_colours() -> None:
    grey = colors()[..., 0]
    for message in (picture("mono8", grey), picture("8UC1", grey), picture("mono16", grey.astype("<u2") << 8)):
        np.testing.assert_array_equal(ros.color_image(message), np.repeat(grey[..., None], 3, axis=2))
        assert ros.encoding_of(message) == "mono"


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_mosaic_of_one_colour_is_that_colour(pattern: str) -> None:
    wanted = {"r": 200, "g": 120, "b": 40}
    cell = np.array([wanted[letter] for letter in pattern], np.uint8).reshape(2, 2)
    found = ros.color_image(picture(f"bayer_{pattern}8", np.tile(cell, (4, 5))))
    np.testing.assert_array_equal(found[2:-2, 2:-2], np.broadcast_to([200, 120, 40], (4, 6, 3)))


def test_yuv_is_read_in_both_orders() -> None:
    u_y_v_y = np.tile(np.array([[90, 81], [240, 81]], np.uint8), (4, 3, 1))  # red in BT.601
    for encoding, pixels in (("yuv422", u_y_v_y), ("yuv422_yuy2", u_y_v_y[..., ::-1])):
        found = ros.color_image(picture(encoding, pixels)).reshape(-1, 3)
        assert np.abs(found.astype(int) - [255, 0, 0]).max() < 8


def test_rows_may_be_padded_and_numbers_big_endian() -> None:
    depth = np.arange(12, dtype=np.uint16).reshape(3, 4) * 300
    padded = np.zeros((3, 6), ">u2")
    padded[:, :4] = depth
    message = picture("16UC1", padded, width=4, is_bigendian=1)
    np.testing.assert_array_equal(ros.depth_image(message), depth)
    cut = picture("rgb8", colors(), step=40, width=8, height=6, data=np.zeros(40 * 6 - 16, np.uint8))
    assert ros.color_image(cut).shape == (6, 8, 3)  # some drivers leave the last row's padding away


def test_a_picture_that_is_too_short_is_refused() -> None:
    for fields in ({"height": 7}, {"step": 10}, {"data": np.zeros(0, np.uint8)}, {"width": 0, "step": 0}):
        with pytest.raises(ros.Unreadable, match="no image of"):
            ros.color_image(picture("rgb8", colors(), **fields))
    with pytest.raises(ros.Unreadable, match="'64FC9'"):
        ros.color_image(picture("64FC9", colors()))
    with pytest.raises(ros.Unreadable, match="no depth"):
        ros.depth_image(picture("rgb8", colors()))


@given(st.floats(0.0, 70.0, width=32))
def test_metres_become_millimetres_where_they_fit(metres: float) -> None:
    (found,) = ros.depth_image(picture("32FC1", np.array([[metres]], "<f4"))).ravel()
    if metres <= 65.535:
        assert abs(float(found) - 1000 * metres) <= 0.51
    else:
        assert found in (0, 65535)


def test_no_measurement_is_zero() -> None:
    message = picture("32FC1", np.array([[np.nan, np.inf, -np.inf, -1.0, 0.0, 70.0, 1.0]], "<f4"))
    np.testing.assert_array_equal(ros.depth_image(message), [[0, 0, 0, 0, 0, 0, 1000]])


def packed(form: str, data: bytes) -> Any:
    fields = {"header": header(STAMP, "cam"), "format": form, "data": np.frombuffer(data, np.uint8)}
    return made(ROS2, "sensor_msgs/msg/CompressedImage", fields)


def png(pixels: NDArray[Any]) -> bytes:
    return cv2.imencode(".png", pixels)[1].tobytes()


def test_packed_pictures_are_recognised_by_their_content() -> None:
    message = packed("rgb8; png compressed bgr8", png(colors()[..., ::-1]))
    np.testing.assert_array_equal(ros.color_image(message), colors())
    assert ros.encoding_of(message) == "color"
    assert ros.encoding_of(packed("mono8; jpeg compressed ", b"")) == "mono"
    assert ros.encoding_of(packed("jpeg", b"")) == "color"
    assert ros.encoding_of(packed("h264", b"")) == ""
    for data in (b"", b"no picture"):
        with pytest.raises(ros.Unreadable, match="neither JPEG nor PNG"):
            ros.color_image(packed("jpeg", data))


def test_packed_depth_in_millimetres() -> None:
    depth = np.arange(20, dtype=np.uint16).reshape(4, 5) * 100
    for form, head in (
        ("16UC1; compressedDepth png", 12),
        ("16UC1; compressedDepth", 12),
        ("16UC1; png compressed ", 0),
    ):
        message = packed(form, bytes(head) + png(depth))
        assert ros.encoding_of(message) == "depth"
        np.testing.assert_array_equal(ros.depth_image(message), depth)


def test_packed_depth_in_metres_is_an_inverse() -> None:
    """image_transport_plugins: A = depth_quantization * (depth_quantization + 1), B = 1 - A / depth_max."""
    metres = np.array([[0.5, 1.0, 2.0, 5.0, np.nan]], np.float32)
    a = 100.0 * 101.0
    b = 1.0 - a / 10.0
    steps = np.where(np.isfinite(metres), np.rint(a / np.nan_to_num(metres, nan=1.0) + b), 0).astype(np.uint16)
    message = packed("32FC1; compressedDepth", struct.pack("<iff", 0, a, b) + png(steps))
    found = ros.depth_image(message)
    np.testing.assert_allclose(found[0, :4], metres[0, :4] * 1000, rtol=0.001)
    assert found[0, 4] == 0


def test_depth_packed_otherwise_is_refused() -> None:
    rvl = packed("16UC1; compressedDepth rvl", bytes(40))
    assert ros.encoding_of(rvl) == ""
    with pytest.raises(ros.Unreadable, match="no PNG"):
        ros.depth_image(rvl)
    with pytest.raises(ros.Unreadable, match="16 bits"):
        ros.depth_image(packed("16UC1; compressedDepth", bytes(12) + png(colors())))


@pytest.mark.parametrize("store", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_the_first_echo_of_each_ray_is_taken(store: Any) -> None:
    echoes = [{"echoes": [1.0, 2.0]}, {"echoes": []}, {"echoes": [3.0]}]
    fields = {
        "header": header(STAMP, "/laser"), "angle_min": -1.0, "angle_increment": 1.0, "range_max": 10.0,
        "scan_time": 0.1, "ranges": echoes, "intensities": [{"echoes": [7.0, 8.0]}] * 3,
    }  # fmt: skip
    scan = ros.laser_scan(made(store, "sensor_msgs/msg/MultiEchoLaserScan", fields), 0.0, Pose3.identity())
    np.testing.assert_array_equal(scan.ranges, np.array([1, np.inf, 3], np.float32))
    np.testing.assert_array_equal(scan.intensities, np.array([7, 7, 7], np.float32))
    assert scan.frame == "laser"
    assert scan.stamp == pytest.approx(STAMP / 1e9, abs=1e-6)
    assert scan.duration_s == pytest.approx(0.1 * 2 / (2 * math.pi))


def test_an_empty_stamp_is_the_arrival() -> None:
    message = made(ROS2, "sensor_msgs/msg/JointState", {"name": ["a", "b"], "position": [0.5]})
    joints = ros.joint_state(message, 12.5)
    assert (joints.stamp, joints.names, joints.positions) == (12.5, ("a",), (0.5,))


def test_velocity_commands_with_and_without_a_stamp() -> None:
    velocity = {"linear": {"x": 0.5, "y": 0.125}, "angular": {"z": -0.25}}
    bare = ros.twist(made(ROS2, "geometry_msgs/msg/Twist", velocity), 3.0)
    assert (bare.stamp, bare.linear_mps, bare.angular_radps, bare.lateral_mps) == (3.0, 0.5, -0.25, 0.125)
    stamped = made(ROS2, "geometry_msgs/msg/TwistStamped", {"header": header(STAMP, ""), "twist": velocity})
    assert ros.twist(stamped, 3.0).stamp == pytest.approx(STAMP / 1e9, abs=1e-6)


@given(st.floats(-3.1, 3.1), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_heading_is_of_the_x_axis_on_the_ground(heading: float, roll: float, pitch: float) -> None:
    pose = Pose3.from_translation_rpy((1.0, 2.0, 3.0), (roll, pitch, heading))
    w, x, y, z = pose.quaternion_wxyz()
    assert ros.yaw(SimpleNamespace(w=w, x=x, y=y, z=z)) == pytest.approx(heading, abs=1e-9)
    seen = ros.heading(pose)
    assert (seen.x, seen.y, seen.theta) == pytest.approx((1.0, 2.0, heading), abs=1e-9)


@pytest.mark.parametrize("store", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_a_reading_that_is_no_number_says_nothing(store: Any) -> None:
    fields = {
        "header": header(STAMP, "/laser"), "angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.0,
        "range_max": 10.0, "ranges": np.array([1.0, np.nan, -np.inf, -1.0, np.inf, 11.0], np.float32),
    }  # fmt: skip
    scan = ros.laser_scan(made(store, "sensor_msgs/msg/LaserScan", fields), 0.0, Pose3.identity())
    np.testing.assert_array_equal(scan.ranges, np.array([1, 0, 0, 0, np.inf, np.inf], np.float32))
    assert scan.range_min > 0.0
