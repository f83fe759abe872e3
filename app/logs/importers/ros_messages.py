"""ROS messages of common sensors into ours: pure functions on what rosbags makes of a message.

ROS 1 and ROS 2 differ in none of the fields used here, as rosbags gives them. Definitions: sensor_msgs, nav_msgs,
geometry_msgs of ROS's ``common_interfaces``; ``compressedDepth``: image_transport_plugins.
"""

from __future__ import annotations

import math
import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.base.image_source import TooLarge, decoded
from app.logs.stamps import SECOND, from_ns
from app.messages import JointState, LaserScan, Odometry, Twist, read_only

#: Pixels' channels and, for the others than 8-bit colour, what OpenCV calls the way to RGB.
_COLOR = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "8UC3": 3, "8UC4": 4}
_TO_RGB = {
    "bgr8": cv2.COLOR_BGR2RGB,
    "8UC3": cv2.COLOR_BGR2RGB,
    "rgba8": cv2.COLOR_RGBA2RGB,
    "bgra8": cv2.COLOR_BGRA2RGB,
    "8UC4": cv2.COLOR_BGRA2RGB,
    "mono8": cv2.COLOR_GRAY2RGB,
    "8UC1": cv2.COLOR_GRAY2RGB,
    "bayer_rggb8": cv2.COLOR_BayerRGGB2RGB,
    "bayer_bggr8": cv2.COLOR_BayerBGGR2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGBRG2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGRBG2RGB,
    "yuv422": cv2.COLOR_YUV2RGB_UYVY,
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "yuv422_yuy2": cv2.COLOR_YUV2RGB_YUYV,
    "yuyv": cv2.COLOR_YUV2RGB_YUYV,
}
_TWO_BYTES = {"yuv422", "uyvy", "yuv422_yuy2", "yuyv"}
_DEPTH = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
#: Least distance (m) that a laser measures; 0 is unknown.
_RANGE_MIN_M = 1e-3
_GREY = {"mono8", "8UC1", "mono16"}
#: Head of compressedDepth before its PNG: int32 format, float32 A and B of its inverse depth.
_DEPTH_HEADER = struct.Struct("<iff")
_PNG = b"\x89PNG"


class Unreadable(ValueError):
    """A message that cannot be converted to one of ours; its text gives the reason."""


def stamp_of(message: Any, at: float) -> float:
    """Capture (s) of a message with a header; its arrival ``at`` (s) where the driver left the stamp empty."""
    stamp = message.header.stamp
    return from_ns(stamp.sec * SECOND + stamp.nanosec) if stamp.sec or stamp.nanosec else at


def frame_of(message: Any) -> str:
    """Frame of a message with a header, without the slash some ROS 1 drivers begin it with."""
    return str(message.header.frame_id).lstrip("/")


def yaw(q: Any) -> float:
    """Heading (rad) of a quaternion message: of the x axis, projected on the ground."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def heading(pose: Pose3) -> Pose2:
    """``pose`` seen from above."""
    x, y, _ = pose.translation
    return Pose2(float(x), float(y), math.atan2(float(pose.rotation[1, 0]), float(pose.rotation[0, 0])))


def odometry(message: Any, at: float) -> Odometry:
    """nav_msgs/Odometry."""
    pose, twist = message.pose.pose, message.twist.twist
    X_OB = Pose2(float(pose.position.x), float(pose.position.y), yaw(pose.orientation))
    linear, angular, lateral = _planar(twist)
    return Odometry(stamp_of(message, at), X_OB, linear, angular, lateral_mps=lateral)


def joint_state(message: Any, at: float) -> JointState:
    """sensor_msgs/JointState; names without a position are left out, and efforts unless there is one for each."""
    pairs = list(zip(message.name, message.position, strict=False))
    efforts = tuple(float(e) for e in message.effort) if len(message.effort) == len(pairs) else ()
    names, positions = tuple(str(n) for n, _ in pairs), tuple(float(p) for _, p in pairs)
    return JointState(stamp_of(message, at), names, positions, efforts)


def twist(message: Any, at: float) -> Twist:
    """geometry_msgs/Twist, which has no stamp of its own and takes its arrival ``at`` (s), or TwistStamped."""
    if hasattr(message, "header"):
        return Twist(stamp_of(message, at), *_planar(message.twist))
    return Twist(at, *_planar(message))


def _planar(twist: Any) -> tuple[float, float, float]:
    """Forward m/s, turn rad/s and sideways m/s of a geometry_msgs/Twist."""
    return float(twist.linear.x), float(twist.angular.z), float(twist.linear.y)


def laser_scan(message: Any, at: float, X_BL: Pose3) -> LaserScan:
    """sensor_msgs/LaserScan, or MultiEchoLaserScan with the first echo of each ray.

    Ranges above ``range_max`` become +inf: nothing was seen. NaN, -inf and ranges below 0 become 0: unknown (REP 117).
    """
    ranges, intensities = _first_echoes(message.ranges), _first_echoes(message.intensities)
    known = np.where(ranges >= 0.0, ranges, np.float32(0))  # NaN is not
    ranges = np.where(known > message.range_max, np.float32(np.inf), known)
    if intensities.size != ranges.size:
        intensities = np.zeros_like(ranges)
    duration = float(message.time_increment) * max(ranges.size - 1, 0)
    if duration <= 0.0 and message.angle_increment:
        turn = abs(float(message.angle_increment)) * max(ranges.size - 1, 0)
        duration = float(message.scan_time) * min(turn / (2 * math.pi), 1.0)
    return LaserScan(
        stamp_of(message, at),
        frame_of(message),
        ranges=read_only(ranges),
        intensities=read_only(intensities),
        angle_min=float(message.angle_min),
        angle_increment=float(message.angle_increment),
        range_min=max(float(message.range_min), _RANGE_MIN_M),
        range_max=float(message.range_max),
        duration_s=duration,
        X_BL=X_BL,
    )


def _first_echoes(values: Any) -> NDArray[np.float32]:
    if len(values) and hasattr(values[0], "echoes"):
        return np.array([ray.echoes[0] if len(ray.echoes) else np.inf for ray in values], dtype=np.float32)
    return np.array(values, dtype=np.float32)


def encoding_of(message: Any) -> str:
    """Kind of an image: ``color``, ``mono`` or ``depth``; "" if this program cannot read it."""
    if hasattr(message, "encoding"):
        encoding = str(message.encoding)
        if encoding in ("16UC1", "32FC1"):
            return "depth"
        if encoding in _GREY:
            return "mono"
        return "color" if encoding in _TO_RGB or encoding == "rgb8" else ""
    form = str(message.format)
    if "compressedDepth" in form:
        return "depth" if _PNG in bytes(message.data[: _DEPTH_HEADER.size + len(_PNG)]) else ""
    source = form.split(";")[0].strip()
    if source in ("16UC1", "32FC1"):
        return "depth"
    if not any(kind in form.lower() for kind in ("jpeg", "jpg", "png")):
        return ""
    return "mono" if source in _GREY else "color"


def color_image(message: Any) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB of a sensor_msgs/Image or CompressedImage. Raises Unreadable."""
    if not hasattr(message, "encoding"):
        picture = _decoded(message.data, cv2.IMREAD_COLOR_RGB)
        if picture is None:
            raise Unreadable("the picture is neither JPEG nor PNG")
        return np.asarray(picture, np.uint8)
    encoding = str(message.encoding)
    if encoding == "mono16":
        grey = (_pixels(message, "u2", 1) >> 8).astype(np.uint8)
        return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB), np.uint8)
    if encoding != "rgb8" and encoding not in _TO_RGB:
        raise Unreadable(f"the encoding {encoding!r} is none of {', '.join(sorted({'rgb8', *_TO_RGB}))}")
    pixels = _pixels(message, "u1", 2 if encoding in _TWO_BYTES else _COLOR.get(encoding, 1))
    return pixels.copy() if encoding == "rgb8" else np.asarray(cv2.cvtColor(pixels, _TO_RGB[encoding]), np.uint8)


def depth_image(message: Any) -> NDArray[np.uint16]:
    """(H, W) uint16 mm of a depth Image (16UC1 mm, 32FC1 m) or compressed one; 0 = none measured. Raises Unreadable."""
    if not hasattr(message, "encoding"):
        return _compressed_depth(message)
    kind = _DEPTH.get(str(message.encoding))
    if kind is None:
        raise Unreadable(f"the encoding {message.encoding!r} is no depth: 16UC1 or 32FC1")
    pixels = _pixels(message, kind, 1)
    return _millimetres(pixels) if kind == "f4" else pixels.astype(np.uint16)


def _pixels(message: Any, kind: str, channels: int) -> NDArray[Any]:
    """(H, W) or (H, W, channels) of a raw image, without the padding of its rows."""
    dtype = np.dtype((">" if message.is_bigendian else "<") + kind)
    height, width, step = int(message.height), int(message.width), int(message.step)
    used = width * channels * dtype.itemsize
    data = np.asarray(message.data, np.uint8)
    step = step or used
    if step < used or data.size < step * (height - 1) + used or not used or not height:
        raise Unreadable(f"{data.size} bytes are no image of {width} x {height} with rows of {step} bytes")
    rows = np.lib.stride_tricks.as_strided(data, (height, used), (step, 1), writeable=False)
    pixels = np.ascontiguousarray(rows).view(dtype)
    return pixels if channels == 1 else pixels.reshape(height, width, channels)


def _decoded(data: Any, flags: int) -> NDArray[Any] | None:
    try:
        return decoded(np.asarray(data, np.uint8), flags)
    except TooLarge as failure:
        raise Unreadable(f"the picture {failure}") from None


def _millimetres(metres: NDArray[Any]) -> NDArray[np.uint16]:
    known = np.isfinite(metres) & (metres > 0) & (metres < 65.5355)
    return np.where(known, np.rint(np.where(known, metres, 0) * 1000.0), 0).astype(np.uint16)


def _compressed_depth(message: Any) -> NDArray[np.uint16]:
    data = np.asarray(message.data, np.uint8)
    form = str(message.format)
    head = bytes(data[: _DEPTH_HEADER.size + len(_PNG)])
    if not head.startswith(_PNG):
        if not head.endswith(_PNG):
            raise Unreadable(f"depth of the format {form!r} is no PNG")
        data = data[_DEPTH_HEADER.size :]
    picture = _decoded(data, cv2.IMREAD_UNCHANGED)
    if picture is None or picture.ndim != 2 or picture.dtype != np.uint16:
        raise Unreadable("the PNG of the depth is damaged or has no 16 bits")
    if not form.startswith("32FC1") or head.startswith(_PNG):
        return np.asarray(picture, np.uint16)
    _, a, b = _DEPTH_HEADER.unpack_from(head)
    # 32FC1 is kept as the inverse of depth, in steps: A / z + B.
    known = picture > 0
    inverse = np.where(known, picture.astype(np.float32) - b, 1)
    return _millimetres(np.where(known & (inverse > 0), a / np.where(inverse > 0, inverse, 1), 0))
