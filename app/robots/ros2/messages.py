"""ROS messages as rclpy gives them into ours; those that logs have, too, by the functions of logs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from app.base.geometry import Pose3
from app.logs.importers import ros_messages
from app.logs.importers.ros_messages import Unreadable
from app.logs.importers.ros_stream import followed
from app.logs.importers.transforms import StampedTransform
from app.logs.stamps import SECOND, from_ns, to_ns
from app.messages import BatteryState, Odometry
from app.robots.ros2.camera import CameraReader
from app.robots.ros2.config import DEPTH, INFO

#: sensor_msgs/BatteryState: values of ``power_supply_status`` with a charger.
_CHARGING, _FULL = 1, 4

Converter = Callable[[Any, float], Any]


def seconds(stamp: Any) -> float:
    """Seconds of a builtin_interfaces/Time."""
    return from_ns(stamp.sec * SECOND + stamp.nanosec)


def stamp_of(message: Any) -> float | None:
    """Stamp (s) of a message with a header, None where its sender left it empty."""
    stamp = message.header.stamp
    return seconds(stamp) if stamp.sec or stamp.nanosec else None


def set_stamp(header: Any, stamp: float | None) -> None:
    """Write ``stamp`` (s) into a std_msgs/Header; None leaves it empty."""
    if stamp is not None:
        header.stamp.sec, header.stamp.nanosec = divmod(to_ns(stamp), SECOND)


def odometry(message: Any, at: float) -> Odometry:
    """nav_msgs/Odometry. Raises Unreadable for a value that is not finite."""
    read = ros_messages.odometry(message, at)
    pose = read.X_OB
    values = (pose.x, pose.y, pose.theta, read.linear_mps, read.angular_radps, read.lateral_mps)
    if not all(map(math.isfinite, values)):
        raise Unreadable("its pose or its twist has a value that is not finite")
    return read


class TransformOdometry:
    """Odometry of the transforms of ``child`` in ``frame``; its velocity is what led from one to the next."""

    def __init__(self, frame: str, child: str) -> None:
        self._frame, self._child = frame, child
        self._last: Odometry | None = None

    def pick(self, message: Any) -> Any | None:
        """The TransformStamped of a TFMessage; None where it has none of these frames."""
        frames = self._frame, self._child
        return next(
            (
                each
                for each in message.transforms
                if (each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")) == frames
            ),
            None,
        )

    def __call__(self, stamped: Any, at: float) -> Odometry | None:
        """The odometry of time ``at`` (s); None of what is no later than the last. Raises Unreadable."""
        t, q = stamped.transform.translation, stamped.transform.rotation
        turn = (float(q.x), float(q.y), float(q.z), float(q.w))
        if not all(map(math.isfinite, (t.x, t.y, *turn))) or not any(turn):
            raise Unreadable(f"the transform of {self._child} has a value that is not finite, or no rotation")
        if self._last is not None and at <= self._last.stamp:
            return None
        placed = StampedTransform(at, (float(t.x), float(t.y), float(t.z)), turn)
        self._last = followed(self._last, at, placed.pose())
        return self._last


def battery(message: Any, at: float) -> BatteryState:
    """sensor_msgs/BatteryState. Raises Unreadable where it does not give the charge."""
    charge = float(message.percentage)
    if not 0.0 <= charge <= 1.0:
        raise Unreadable(f"its percentage is {charge:g}; a share of the capacity is 0 to 1")
    voltage, current = (0.0 if math.isnan(value) else float(value) for value in (message.voltage, message.current))
    charging = int(message.power_supply_status) in (_CHARGING, _FULL)
    return BatteryState(at, charge, voltage_v=voltage, current_a=current, charging=charging, remaining_s=None)


def converters(
    X_BL: Pose3 | None,
    cameras: Mapping[str, CameraReader] | None = None,
    transforms: TransformOdometry | None = None,
) -> dict[str, Converter]:
    """How the message of each reading is read; ``X_BL``: pose of the laser in ``base_link``; ``cameras`` by stream;
    ``transforms``: where odometry is of these.

    The second argument of each is the message's time (s), whatever its header says. Those of cameras give None while an
    image is not complete.
    """
    plain: dict[str, Converter] = {
        "odometry": odometry,
        "joints": ros_messages.joint_state,
        "battery": battery,
    }
    if X_BL is not None:
        plain["hokuyo"] = lambda message, at: ros_messages.laser_scan(message, at, X_BL)

    def placed(convert: Converter) -> Converter:
        return lambda message, at: replace(convert(message, at), stamp=at)

    found = {name: placed(convert) for name, convert in plain.items()}
    if transforms is not None:
        found["odometry"] = transforms
    for name, camera in (cameras or {}).items():
        found |= {name: camera.picture, f"{name}.{INFO}": camera.info, f"{name}.{DEPTH}": camera.depth}
    return found
