"""ROS messages into ours. Their classes are stood for by plain objects with the same fields."""

from __future__ import annotations

import math
from types import SimpleNamespace as Fields
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose3
from app.logs.importers.ros_messages import Unreadable
from app.messages import BatteryState, LaserScan, Odometry
from app.robots.ros2.messages import TransformOdometry, battery, converters, imu, odometry, set_stamp, stamp_of

AT = 1_700_000_000.25


def header(sec: int = 12, nanosec: int = 500_000_000, frame: str = "odom") -> Fields:
    return Fields(stamp=Fields(sec=sec, nanosec=nanosec), frame_id=frame)


def drive(x: float = 1.0) -> Fields:
    position, orientation = Fields(x=x, y=2.0, z=0.0), Fields(x=0.0, y=0.0, z=math.sin(0.25), w=math.cos(0.25))
    twist = Fields(linear=Fields(x=0.2, y=0.0, z=0.0), angular=Fields(x=0.0, y=0.0, z=-0.1))
    return Fields(
        header=header(), pose=Fields(pose=Fields(position=position, orientation=orientation)), twist=Fields(twist=twist)
    )


def test_the_time_that_a_message_is_given_replaces_its_own() -> None:
    read = converters()["odometry"](drive(), AT)
    assert isinstance(read, Odometry)
    assert read.stamp == AT
    assert read.X_OB.theta == pytest.approx(0.5)
    assert (read.X_OB.x, read.X_OB.y, read.linear_mps, read.angular_radps) == (1.0, 2.0, 0.2, -0.1)


def test_a_pose_that_is_no_number_is_refused() -> None:
    with pytest.raises(Unreadable, match="a value that is not finite"):
        odometry(drive(x=math.nan), AT)


def test_a_scan_is_placed_by_the_mapping() -> None:
    X_BL = Pose3.identity()
    message = Fields(
        header=header(frame="laser"), ranges=[0.5, math.inf, math.nan], intensities=[], angle_min=-1.0, angle_max=1.0,
        angle_increment=1.0, time_increment=0.0, scan_time=0.1, range_min=0.15, range_max=12.0,
    )  # fmt: skip
    read = converters({"hokuyo": ("laser", X_BL)})["hokuyo"](message, AT)
    assert isinstance(read, LaserScan)
    assert np.array_equal(read.ranges, np.array([0.5, np.inf, 0.0], np.float32))
    assert (read.stamp, read.frame, read.X_BL) == (AT, "laser", X_BL)


def charged(**fields: Any) -> Fields:
    values = {"percentage": 0.8, "voltage": 15.2, "current": -0.6, "power_supply_status": 2}
    return Fields(header=header(), **(values | fields))


def test_a_battery() -> None:
    assert battery(charged(), AT) == BatteryState(AT, 0.8, 15.2, -0.6, charging=False, remaining_s=None)
    assert battery(charged(power_supply_status=1), AT).charging
    assert battery(charged(current=math.nan), AT).current_a == 0.0
    with pytest.raises(Unreadable, match="its percentage is nan; a share of the capacity is 0 to 1"):
        battery(charged(percentage=math.nan), AT)
    with pytest.raises(Unreadable, match="its percentage is 80"):
        battery(charged(percentage=80.0), AT)


def test_stamps_go_both_ways() -> None:
    assert stamp_of(Fields(header=header())) == 12.5
    assert stamp_of(Fields(header=header(0, 0))) is None
    written = header(0, 0)
    set_stamp(written, 12.5)
    assert stamp_of(Fields(header=written)) == 12.5
    set_stamp(written, None)
    assert stamp_of(Fields(header=written)) == 12.5


def transform(x: float, theta: float = 0.0, child: str = "base_link") -> Fields:
    moved = Fields(
        translation=Fields(x=x, y=0.0, z=0.0),
        rotation=Fields(x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2)),
    )
    return Fields(header=header(), child_frame_id=child, transform=moved)


def test_odometry_of_transforms_has_the_velocity_that_led_there() -> None:
    read = TransformOdometry("odom", "base_link")
    message = Fields(transforms=[transform(9.0, child="wheel"), transform(1.0)])
    assert read.pick(message) is message.transforms[1]
    assert read.pick(Fields(transforms=[transform(9.0, child="wheel")])) is None
    first, then = read(transform(1.0), 10.0), read(transform(1.1), 10.5)
    assert first is not None
    assert then is not None
    assert (first.X_OB.x, first.linear_mps, then.stamp) == (1.0, 0.0, 10.5)
    assert (then.linear_mps, then.angular_radps) == pytest.approx((0.2, 0.0))
    assert read(transform(1.2), 10.5) is None  # published again
    turned = read(transform(1.1, 0.3), 11.0)
    assert turned is not None
    assert turned.angular_radps == pytest.approx(0.6)
    with pytest.raises(Unreadable):
        read(transform(math.nan), 12.0)


class Inertial(Fields):
    """A sensor_msgs/Imu of a sensor that measures all, with no word on how well."""

    def __init__(self, **given: Any) -> None:
        fields = {
            "header": header(),
            "orientation": Fields(x=0.0, y=0.0, z=0.0, w=1.0),
            "angular_velocity": Fields(x=0.1, y=0.2, z=0.3),
            "linear_acceleration": Fields(x=1.0, y=2.0, z=9.0),
            "orientation_covariance": [0.0] * 9,
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration_covariance": [0.0] * 9,
        }
        super().__init__(**(fields | given))


def diagonal(x: float, y: float, z: float) -> list[float]:
    return [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z]


def test_an_inertial_sensor_is_turned_into_the_axes_of_the_base() -> None:
    # Mounted upside down, its x to the right of the robot: as that of a Stretch.
    place = Pose3.from_translation_rpy((-0.1, 0.0, 0.1), (math.pi, 0.0, -math.pi / 2))
    felt = imu(Inertial(angular_velocity_covariance=diagonal(1.0, 4.0, 9.0)), AT, "imu_link", place)
    assert (felt.stamp, felt.frame) == (AT, "imu_link")
    assert felt.angular_velocity == pytest.approx((-0.2, -0.1, -0.3))
    assert felt.specific_force == pytest.approx((-2.0, -1.0, -9.0))
    assert felt.angular_velocity_covariance == pytest.approx(diagonal(4.0, 1.0, 9.0))
    assert (felt.specific_force_covariance, felt.attitude, felt.attitude_covariance) == (None, None, None)


def test_an_attitude_is_that_of_the_base() -> None:
    place = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0))
    rolled = Fields(x=math.sin((math.pi + 0.2) / 2), y=0.0, z=0.0, w=math.cos((math.pi + 0.2) / 2))
    felt = imu(Inertial(orientation=rolled, orientation_covariance=diagonal(0.1, 0.1, 0.2)), AT, "imu", place)
    assert felt.attitude == pytest.approx((math.sin(0.1), 0.0, 0.0, math.cos(0.1)))
    assert felt.attitude_covariance == tuple(diagonal(0.1, 0.1, 0.2))
    none = imu(Inertial(orientation=rolled, orientation_covariance=[-1.0] + [0.0] * 8), AT, "imu", place)
    assert none.attitude is None


def test_an_inertial_sensor_that_measures_nothing_is_not_read() -> None:
    place = Pose3.identity()
    with pytest.raises(Unreadable, match="does not measure angular velocity, or acceleration"):
        imu(Inertial(linear_acceleration_covariance=[-1.0] + [0.0] * 8), AT, "imu", place)
    with pytest.raises(Unreadable, match="not finite"):
        imu(Inertial(angular_velocity=Fields(x=math.nan, y=0.0, z=0.0)), AT, "imu", place)
