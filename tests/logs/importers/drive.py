"""A drive of another robot along a curve: the data of its sensors, and the true poses.

The base drives an arc; a laser is on it, turned; a camera on a neck that pans. Colour comes at 10 Hz, depth 4 ms after
it and later to arrive, the neck's and the base's transforms at 25 Hz between the pictures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from tests.logs.importers.bags import Sent, header

BEGIN = 1_700_000_000 * 10**9
SECONDS = 4.0
SPEED, TURN, PAN = 0.4, 0.25, 0.5
K = [525.0, 0.0, 159.5, 0.0, 525.0, 119.5, 0.0, 0.0, 1.0]
P = [525.0, 0.0, 159.5, 0.0, 0.0, 525.0, 119.5, 0.0, 0.0, 0.0, 1.0, 0.0]
RANGES = np.array([0.5, 1.5, np.inf, 5.0, 12.0, np.nan, 0.02], np.float32)
X_BL = Pose3.from_translation_rpy((0.2, -0.1, 0.3), (math.pi, 0.0, 0.5))
X_BN = Pose3.from_translation_rpy((0.1, 0.0, 1.1))
X_NC = Pose3.from_translation_rpy((0.05, 0.02, 0.0), (-math.pi / 2, 0.0, -math.pi / 2))
OPTICAL = "camera_rgb_optical_frame"


def ns(seconds: float) -> int:
    """Nanoseconds since the epoch of a time of the drive."""
    return BEGIN + round(seconds * 1e9)


def base_at(stamp: float) -> Pose2:
    """Where the base is at ``stamp`` (s since the epoch): on its arc."""
    t = stamp - BEGIN / 1e9
    r = SPEED / TURN
    return Pose2(r * math.sin(TURN * t), r * (1 - math.cos(TURN * t)), TURN * t)


def camera_at(stamp: float) -> Pose3:
    """``X_BC``: where the camera is in the base at ``stamp`` (s since the epoch)."""
    pan = PAN * (stamp - BEGIN / 1e9)
    return X_BN @ Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.0, pan)) @ X_NC


def color_at(number: int) -> NDArray[np.uint8]:
    """(240, 320, 3) RGB of picture ``number``: a slope of colours that says which it is."""
    v, u = np.mgrid[0:240, 0:320]
    return np.stack((u * 200 // 320, v, np.full_like(u, 10 * (number % 20))), axis=-1).astype(np.uint8)


def depth_at(number: int) -> NDArray[np.uint16]:
    """(240, 320) mm: a wall that comes nearer, with a hole."""
    depth = np.full((240, 320), 3000 - 10 * number, np.uint16)
    depth[:20, :20] = 0
    return depth


#: Colour and depth of picture ``number``, taken at ``stamp`` (s since the epoch).
View = Callable[[int, float], tuple[NDArray[np.uint8], NDArray[np.uint16]]]


def slope(number: int, stamp: float) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
    """What the camera sees unless something else hangs before it."""
    return color_at(number), depth_at(number)


def drive(*, odometry: bool = True, compressed: bool = False, metres: bool = False, view: View = slope) -> list[Sent]:
    """All messages in the order of their arrival."""
    sent = list(_static())
    sent += _moving()
    sent += _pictures(view, compressed=compressed, metres=metres)
    sent += _others(odometry=odometry)
    return sorted(sent, key=lambda message: message.at)


def transform(stamp: int, parent: str, child: str, pose: Pose3) -> dict[str, Any]:
    """A geometry_msgs/TransformStamped."""
    w, x, y, z = pose.quaternion_wxyz()
    translation = dict(zip("xyz", (float(value) for value in pose.translation), strict=True))
    return {
        "header": header(stamp, parent),
        "child_frame_id": child,
        "transform": {"translation": translation, "rotation": {"x": x, "y": y, "z": z, "w": w}},
    }


def _static() -> Iterator[Sent]:
    transforms = [
        transform(BEGIN, "base_link", "laser", X_BL),
        transform(BEGIN, "base_link", "neck_base", X_BN),
        transform(BEGIN, "neck", OPTICAL, X_NC),
    ]
    yield Sent(ns(0.001), "/tf_static", "tf2_msgs/msg/TFMessage", {"transforms": transforms})


def _moving() -> Iterator[Sent]:
    for i in range(int(SECONDS * 25)):
        stamp = ns(i * 0.04 + 0.013)
        base = base_at(stamp / 1e9).to_pose3()
        pan = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.0, PAN * (stamp - BEGIN) / 1e9))
        transforms = [transform(stamp, "odom", "base_link", base), transform(stamp, "neck_base", "neck", pan)]
        yield Sent(stamp + 30_000_000, "/tf", "tf2_msgs/msg/TFMessage", {"transforms": transforms})


def _pictures(view: View, *, compressed: bool, metres: bool) -> Iterator[Sent]:
    for i in range(int(SECONDS * 10)):
        stamp = ns(0.1 * i + 0.05)
        at = stamp + 20_000_000
        info = {"width": 320, "height": 240, "distortion_model": "plumb_bob", "d": [0.0] * 5, "k": K, "p": P}
        yield Sent(
            at, "/camera/rgb/camera_info", "sensor_msgs/msg/CameraInfo", {"header": header(stamp, OPTICAL), **info}
        )
        color, depth = view(i, stamp / 1e9)
        if compressed:
            packed = cv2.imencode(".jpg", cv2.cvtColor(color, cv2.COLOR_RGB2BGR), (cv2.IMWRITE_JPEG_QUALITY, 95))[1]
            fields: dict[str, Any] = {"format": "rgb8; jpeg compressed bgr8", "data": packed}
            yield Sent(
                at + 1, "/camera/rgb/image_raw/compressed", "sensor_msgs/msg/CompressedImage",
                {"header": header(stamp, OPTICAL), **fields},
            )  # fmt: skip
        else:
            yield Sent(
                at + 1, "/camera/rgb/image_raw", "sensor_msgs/msg/Image",
                {"header": header(stamp, OPTICAL), **image("bgr8", color[..., ::-1])},
            )  # fmt: skip
        pixels = (
            image("32FC1", np.where(depth > 0, depth / 1000, np.nan).astype("<f4")) if metres else image("16UC1", depth)
        )
        yield Sent(
            at + 60_000_000, "/camera/depth_registered/image_raw", "sensor_msgs/msg/Image",
            {"header": header(stamp + 4_000_000, OPTICAL), **pixels},
        )  # fmt: skip


def image(encoding: str, pixels: NDArray[Any]) -> dict[str, Any]:
    """The fields of a sensor_msgs/Image but its header."""
    data = np.frombuffer(np.ascontiguousarray(pixels).tobytes(), np.uint8)
    height = pixels.shape[0]
    return {
        "height": height, "width": pixels.shape[1], "encoding": encoding, "is_bigendian": 0,
        "step": data.size // height, "data": data,
    }  # fmt: skip


def _others(*, odometry: bool) -> Iterator[Sent]:
    for i in range(int(SECONDS * 20)):
        stamp = ns(0.05 * i + 0.02)
        scan = {
            "angle_min": -1.5, "angle_max": 1.5, "angle_increment": 0.5, "time_increment": 0.001, "scan_time": 0.05,
            "range_min": 0.1, "range_max": 10.0, "ranges": RANGES, "intensities": np.arange(7) + i,
        }  # fmt: skip
        yield Sent(stamp + 7_000_000, "/scan", "sensor_msgs/msg/LaserScan", {"header": header(stamp, "laser"), **scan})
        if odometry:
            base = base_at(stamp / 1e9)
            pose = {
                "position": {"x": base.x, "y": base.y, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(base.theta / 2), "w": math.cos(base.theta / 2)},
            }
            twist = {"linear": {"x": SPEED, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": TURN}}
            fields = {"child_frame_id": "base_link", "pose": {"pose": pose, "covariance": [0.0] * 36}}
            yield Sent(
                stamp + 2_000_000, "/odom", "nav_msgs/msg/Odometry",
                {"header": header(stamp, "odom"), **fields, "twist": {"twist": twist, "covariance": [0.0] * 36}},
            )  # fmt: skip
        joints = {"name": ["neck_pan"], "position": [PAN * (stamp - BEGIN) / 1e9], "velocity": [], "effort": []}
        yield Sent(
            stamp + 3_000_000, "/joint_states", "sensor_msgs/msg/JointState", {"header": header(stamp, ""), **joints}
        )
    yield Sent(ns(1.0), "/battery", "sensor_msgs/msg/BatteryState", {"header": header(ns(1.0), "")})
    yield Sent(ns(1.5), "/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": 0.3, "y": 0.0, "z": 0.0}})
