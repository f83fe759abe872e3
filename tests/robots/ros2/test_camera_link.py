"""The simulated lab's robot over real ROS 2, by a mapping with a depth camera on its head: what it sees, and where."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base import paths
from app.messages import Image, LaserScan
from tests.robots.conftest import needs_gl
from tests.robots.ros2.robot import Robot, Ros2Driver, mapping, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    needs_gl,
    pytest.mark.blocking(reason="reads a mapping; nothing else is on the loop"),
]

ROBOTS = paths.config_dir() / "robots"
MAPPING = f"""\
kind: ros2
name: The lab's robot
model: {ROBOTS / "irl1_tr.urdf"}
footprint: [[0.28, -0.28], [0.28, 0.28], [-0.28, 0.28], [-0.28, -0.28]]
height_m: 1.4
limits: {{linear_mps: 0.3, angular_radps: 1.0, linear_mps2: 0.4, angular_radps2: 2.0, required_sensors: [odometry]}}
streams:
  odometry: {{topic: odom, rate_hz: 100}}
  joints: {{topic: joint_states, rate_hz: 30}}
  hokuyo: {{topic: scan, rate_hz: 40, link: hokuyo_link}}
  kinect:
    topic: head/color/image_raw/compressed
    info: head/color/camera_info
    depth: head/depth_registered/image_raw
    rate_hz: 15
    link: kinect_optical_frame
base: {{topic: cmd_vel, type: geometry_msgs/msg/TwistStamped, watchdog_s: 0.2}}
"""
#: Heights (m) above the floor within which a point of the camera is at the laser's height.
NEAR_M = 0.03


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "lab_over_ros.yaml"
    path.write_text(MAPPING, "utf-8")
    return path


@pytest.fixture
def robot(tmp_path: Path, file: Path) -> Iterator[Robot]:
    robot = Robot(tmp_path, file=file, body=ROBOTS / "irl1_tr.yaml")
    yield robot
    robot.close()


async def test_the_camera_sees_what_the_laser_measures(robot: Robot, file: Path) -> None:
    async with Ros2Driver(mapping(file)) as driver:
        await driver.wait_for("a picture and a scan", lambda seen: {"kinect", "hokuyo"} <= set(seen))
        image: Image = driver.newest["kinect"]
        scan: LaserScan = driver.newest["hokuyo"]
    assert image.color.shape == (480, 640, 3)
    assert np.std(image.color) > 10
    assert image.depth is not None
    apart = distances(image, scan)
    assert len(apart) > 50
    assert np.median(np.abs(apart)) < 0.05


def distances(image: Image, scan: LaserScan) -> np.ndarray[Any, np.dtype[np.float64]]:
    """By how much (m) points of the camera at the laser's height are farther than the ray in their direction."""
    assert image.depth is not None
    v, u = np.nonzero(image.depth)
    z = image.depth[v, u] / 1000.0
    camera = image.camera
    p_C = np.stack(((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z), axis=1)
    p_B = p_C @ image.X_BC.rotation.T + image.X_BC.translation
    p_L = (p_B - scan.X_BL.translation) @ scan.X_BL.rotation
    p_L = p_L[np.abs(p_L[:, 2]) < NEAR_M]
    rays = np.rint((np.arctan2(p_L[:, 1], p_L[:, 0]) - scan.angle_min) / scan.angle_increment).astype(int)
    known = (rays >= 0) & (rays < len(scan.ranges))
    measured = scan.ranges[rays[known]]
    farther = np.hypot(p_L[known, 0], p_L[known, 1]) - measured
    return farther[np.isfinite(measured) & (measured > scan.range_min)]
