"""ROS messages as rclpy gives them into ours; those that logs have, too, by the functions of logs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.logs.importers import ros_messages
from app.logs.importers.ros_messages import Unreadable
from app.logs.importers.ros_stream import followed
from app.logs.importers.transforms import StampedTransform
from app.logs.stamps import SECOND, from_ns, to_ns
from app.messages import BatteryState, Imu, Odometry
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


def imu(message: Any, at: float, frame: str, X_BI: Pose3) -> Imu:
    """sensor_msgs/Imu of a sensor at ``X_BI``. Raises Unreadable for values that are not finite, and where it does not
    measure how it turns and what it feels."""
    R = X_BI.rotation
    turning, force = _vector(message.angular_velocity), _vector(message.linear_acceleration)
    spread_of_turning, turns = _covariance(message.angular_velocity_covariance)
    spread_of_force, feels = _covariance(message.linear_acceleration_covariance)
    spread_of_attitude, turned = _covariance(message.orientation_covariance)
    if not (turns and feels):
        raise Unreadable("its covariances say that it does not measure angular velocity, or acceleration")
    q = message.orientation
    given = np.array([q.x, q.y, q.z, q.w], np.float64)
    if not np.isfinite(np.concatenate([turning, force, given])).all():
        raise Unreadable("it has a value that is not finite")
    # All zeros is what a sender leaves that knows nothing of it; so is the identity without a covariance.
    known = turned and given.any() and (spread_of_attitude is not None or not np.array_equal(given, (0, 0, 0, 1)))
    attitude = None
    if known:
        w, x, y, z = (StampedTransform(at, (0.0, 0.0, 0.0), tuple(given)).pose() @ X_BI.inverse()).quaternion_wxyz()
        attitude = (x, y, z, w)
    return Imu(
        stamp=at,
        frame=frame,
        angular_velocity=_triple(R @ turning),
        specific_force=_triple(R @ force),
        attitude=attitude,
        angular_velocity_covariance=None if spread_of_turning is None else _flat(R @ spread_of_turning @ R.T),
        specific_force_covariance=None if spread_of_force is None else _flat(R @ spread_of_force @ R.T),
        attitude_covariance=_flat(spread_of_attitude) if known and spread_of_attitude is not None else None,
    )


def _vector(v: Any) -> NDArray[np.float64]:
    return np.array([v.x, v.y, v.z], np.float64)


def _triple(v: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])


def _flat(matrix: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(map(float, matrix.ravel()))


def _covariance(nine: Any) -> tuple[NDArray[np.float64] | None, bool]:
    """A covariance (3, 3), None where it is all zeros: unknown; and whether what it is of is measured: -1 says no."""
    matrix = np.array(nine, np.float64).reshape(3, 3)
    measured = bool(matrix[0, 0] != -1.0)
    return (matrix if measured and matrix.any() and np.isfinite(matrix).all() else None), measured


def converters(
    places: Mapping[str, tuple[str, Pose3]] | None = None,
    cameras: Mapping[str, CameraReader] | None = None,
    transforms: TransformOdometry | None = None,
) -> dict[str, Converter]:
    """How the message of each reading is read; ``places``: link and pose in ``base_link`` of the laser
    (``hokuyo``) and the inertial sensor (``imu``), by stream; ``cameras`` by stream; ``transforms``: where
    odometry is of these.

    The second argument of each is the message's time (s), whatever its header says. Those of cameras give None while an
    image is not complete.
    """
    plain: dict[str, Converter] = {
        "odometry": odometry,
        "joints": ros_messages.joint_state,
        "battery": battery,
    }
    if laser := (places or {}).get("hokuyo"):
        plain["hokuyo"] = lambda message, at: ros_messages.laser_scan(message, at, laser[1])
    if sensor := (places or {}).get("imu"):
        plain["imu"] = lambda message, at: imu(message, at, *sensor)

    def placed(convert: Converter) -> Converter:
        return lambda message, at: replace(convert(message, at), stamp=at)

    found = {name: placed(convert) for name, convert in plain.items()}
    if transforms is not None:
        found["odometry"] = transforms
    for name, camera in (cameras or {}).items():
        found |= {name: camera.picture, f"{name}.{INFO}": camera.info, f"{name}.{DEPTH}": camera.depth}
    return found
