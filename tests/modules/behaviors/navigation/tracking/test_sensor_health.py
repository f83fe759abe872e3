from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose3
from app.messages import Image, LaserScan
from app.modules.behaviors.navigation.tracking.sensor_health import DepthHealth, unfit, update_depth_health

CAMERA = CameraModel.from_vertical_fov(640, 480, math.radians(43))
X_BC = Pose3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0.05, 0.0, 1.4]))


def picture(stamp: float, depth: NDArray[np.uint16] | None) -> Image:
    return Image(stamp, "kinect", np.zeros((480, 640, 3), np.uint8), depth, CAMERA, X_BC)


def alive(seed: int) -> NDArray[np.uint16]:
    return np.random.default_rng(seed).integers(1990, 2010, (480, 640)).astype(np.uint16)


def scan(range_m: float) -> LaserScan:
    ranges, X_BL = np.full(181, range_m, np.float32), Pose3.from_translation_rpy((0.2, 0.0, 0.4))
    return LaserScan(0.0, "hokuyo", ranges, ranges, -math.pi / 2, math.pi / 180, 0.1, 30.0, 0.0125, X_BL)


OLD_SCAN = "the laser scan is too old: the laser or this computer is too slow; 0.3 s is the limit"
OLD_PICTURE = "the depth picture is too old: the camera or this computer is too slow; 0.3 s is the limit"


def test_fresh_sensors_may_be_driven_by() -> None:
    watch = update_depth_health(DepthHealth(), picture(10.0, alive(0)))
    assert watch.problem == ""
    assert unfit(10.2, 10.1, watch) == ""
    assert unfit(10.2, 10.1, None) == "", "a body without a depth camera"


def test_old_and_missing_sensors_may_not() -> None:
    watch = update_depth_health(DepthHealth(), picture(10.0, alive(0)))
    assert unfit(10.2, None, watch) == "no laser scan has come yet"
    assert unfit(10.2, 10.2, DepthHealth()) == "no depth picture has come yet"
    assert unfit(10.8, 10.4, watch) == OLD_SCAN
    assert unfit(10.8, 10.8, watch) == OLD_PICTURE
    assert unfit(19.8, 19.8, watch) == OLD_PICTURE, "a state is reported in one sentence, not in one for each age"
    assert unfit(19.8, 10.4, watch) == OLD_SCAN


@pytest.mark.parametrize("off_s", [5.0, math.nan])
def test_sensors_of_another_clock_may_not(off_s: float) -> None:
    watch = update_depth_health(DepthHealth(), picture(10.0, alive(0)))
    ahead = update_depth_health(DepthHealth(), picture(10.0 + off_s, alive(0)))
    assert unfit(10.0, 10.0 + off_s, watch) == "the laser's stamps are not of the robot's clock"
    assert unfit(10.0, 10.0, ahead) == "the depth camera's stamps are not of the robot's clock"


@pytest.mark.parametrize(
    ("depth", "said"),
    [
        (np.zeros((480, 640), np.uint16), "depth pictures are all zero"),
        (np.full((480, 640), 1500, np.uint16), "depth pictures show one and the same distance everywhere"),
        (alive(0), "the same depth picture comes over and over"),
        (None, "pictures come without depth"),
    ],
    ids=["zero", "constant", "unchanged", "none"],
)
def test_a_camera_that_goes_on_sending_dead_pictures_may_not(depth: NDArray[np.uint16] | None, said: str) -> None:
    watch = update_depth_health(DepthHealth(), picture(10.0, alive(0)))
    for k in range(1, 8):
        watch = update_depth_health(watch, picture(10.0 + k / 15, depth))
        assert watch.problem == said
        assert watch.good == 10.0
    now = 10.0 + 7 / 15
    assert unfit(now, now, watch) == said
    assert unfit(now, now, update_depth_health(watch, picture(now, alive(2)))) == "", "it lives again"


def looking(pan_deg: float, tilt_deg: float) -> Image:
    """A picture of zeros with the head turned left by ``pan_deg`` and down by ``tilt_deg``."""
    head = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, math.radians(tilt_deg), math.radians(pan_deg)))
    turned = Pose3((head @ X_BC).rotation, X_BC.translation)
    return Image(11.0, "kinect", np.zeros((480, 640, 3), np.uint8), np.zeros((480, 640), np.uint16), CAMERA, turned)


@pytest.mark.parametrize(
    ("pan_deg", "tilt_deg", "blind"),
    [
        (0, 0, True),
        (60, 0, False),  # beside the wall
        (-60, 0, False),
        (0, 20, True),
        (0, 60, False),  # at the floor before the wall, 1.6 m down along the view
        (0, -20, True),
        (150, 0, False),  # where the laser does not reach
    ],
)
def test_a_wall_before_the_body_excuses_zeros_only_where_the_head_looks_at_it(
    pan_deg: float, tilt_deg: float, blind: bool
) -> None:
    wall = scan(math.inf)
    angles = wall.angle_min + wall.angle_increment * np.arange(len(wall.ranges))
    # Flat, 0.3 m before the laser, to 30 degrees either side
    wall.ranges[:] = np.where(np.abs(angles) < math.radians(62), 0.3 / np.cos(angles), np.inf)
    problem = update_depth_health(DepthHealth(), looking(pan_deg, tilt_deg), wall).problem
    assert problem == ("" if blind else "depth pictures are all zero")


def test_one_dead_picture_is_no_reason_to_stop() -> None:
    watch = update_depth_health(DepthHealth(), picture(10.0, alive(0)))
    watch = update_depth_health(watch, picture(10.07, np.zeros((480, 640), np.uint16)))
    assert unfit(10.1, 10.1, watch) == ""


def test_before_a_wall_the_camera_may_be_blind_but_not_in_the_open() -> None:
    zeros = picture(11.0, np.zeros((480, 640), np.uint16))
    assert update_depth_health(DepthHealth(), zeros, scan(0.3)).problem == ""
    assert update_depth_health(DepthHealth(), zeros, scan(2.0)).problem == "depth pictures are all zero"
    assert update_depth_health(DepthHealth(), zeros, scan(math.inf)).problem == "depth pictures are all zero"


@pytest.mark.parametrize("range_m", [0.0, 0.05, math.nan])
def test_a_dead_laser_excuses_no_dead_camera(range_m: float) -> None:
    zeros = picture(11.0, np.zeros((480, 640), np.uint16))
    assert update_depth_health(DepthHealth(), zeros, scan(range_m)).problem == "depth pictures are all zero"
