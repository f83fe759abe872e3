"""Scans and images with the poses at their stamps: none without, none twice."""

from __future__ import annotations

import numpy as np

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image, LaserScan, read_only
from app.modules.behaviors.navigation.tracking.posed_readings import PosedReadings


class Odometry:
    """The body drives along x at 1 m/s; known until ``until`` (s)."""

    def __init__(self, until: float) -> None:
        self.until = until

    def at(self, stamp: float) -> Pose2 | None:
        return Pose2(stamp) if stamp <= self.until else None


def image(stamp: float) -> Image:
    pixels, camera = read_only(np.zeros((4, 4, 3), np.uint8)), CameraModel.from_vertical_fov(4, 4, 0.75)
    return Image(stamp, "kinect", pixels, None, camera, Pose3.identity())


def scan(stamp: float, duration_s: float = 0.0) -> LaserScan:
    ranges = read_only(np.ones(3, np.float32))
    return LaserScan(
        stamp, "hokuyo_link", ranges, ranges, angle_min=-1.0, angle_increment=1.0, range_min=0.1, range_max=5.0,
        duration_s=duration_s, X_BL=Pose3.identity(),
    )  # fmt: skip


def test_a_scan_waits_for_the_pose_of_its_last_ray() -> None:
    odometry = Odometry(until=1.02)
    readings = PosedReadings(odometry.at)
    sweep = scan(1.0, duration_s=0.025)
    readings.add_scan(sweep)
    assert readings.take_scan() is None
    odometry.until = 1.03
    assert readings.take_scan() == (sweep, Pose2(1.0), Pose2(1.025))
    assert readings.take_scan() is None


def test_an_image_is_given_once() -> None:
    odometry = Odometry(until=0.9)
    readings = PosedReadings(odometry.at)
    assert readings.take_image() is None
    picture = image(1.0)
    readings.add_image(picture)
    assert readings.take_image() is None
    assert readings.image is picture
    odometry.until = 1.0
    assert readings.take_image() == (picture, Pose2(1.0))
    assert readings.take_image() is None


def test_the_newest_reading_takes_the_place_of_one_that_waits() -> None:
    readings = PosedReadings(Odometry(until=5.0).at)
    old, new = scan(1.0), scan(1.025)
    readings.add_scan(old)
    readings.add_scan(new)
    taken = readings.take_scan()
    assert taken is not None
    assert taken[0] is new
