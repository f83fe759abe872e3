"""Calibrations: a distorted picture becomes what a pinhole camera would have seen, others stay as they are."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from app.logs.importers.ros_camera import CameraInfo, PinholeCamera, fitted
from tests.logs.importers.bags import ROS1, ROS2, made

K = np.array([[300.0, 0.0, 160.0], [0.0, 300.0, 120.0], [0.0, 0.0, 1.0]])
P = np.array([[280.0, 0.0, 150.0, 0.0], [0.0, 280.0, 110.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
LENS = [-0.3, 0.1, 0.001, -0.001, 0.0]
FISHEYE = [0.05, -0.01, 0.002, 0.0]


def calibration(d: list[float], model: str = "plumb_bob") -> CameraInfo:
    return CameraInfo(320, 240, model, K, np.array(d), P)


@pytest.mark.parametrize("store", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_camera_info_is_read_in_both_spellings(store: Any) -> None:
    fields = {"width": 320, "height": 240, "distortion_model": "plumb_bob", "d": LENS, "k": K.ravel(), "p": P.ravel()}
    found = CameraInfo.of(made(store, "sensor_msgs/msg/CameraInfo", fields))
    assert found is not None
    assert (found.width, found.height, found.model) == (320, 240, "plumb_bob")
    np.testing.assert_array_equal(found.K, K)
    np.testing.assert_array_equal(found.D, LENS)
    np.testing.assert_array_equal(found.P, P)
    assert CameraInfo.of(made(store, "sensor_msgs/msg/CameraInfo", {})) is None


@pytest.mark.parametrize(
    ("model", "d"), [("plumb_bob", LENS), ("rational_polynomial", [*LENS, 0, 0, 0]), ("equidistant", FISHEYE)]
)
def test_points_in_an_undistorted_picture_lie_where_a_pinhole_camera_has_them(model: str, d: list[float]) -> None:
    camera = PinholeCamera(calibration(d, model), 320, 240, rectified=False)
    assert camera.undistorts
    points = np.array([[-0.3, -0.2, 1.0], [0.25, 0.2, 1.0], [0.0, 0.0, 1.0], [0.3, -0.25, 1.0]])
    if model == "equidistant":
        seen = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), K, np.array(d))[0][:, 0]
    else:
        seen = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, np.array(d))[0][:, 0]
    v, u = np.mgrid[0:240, 0:320]
    for point, (x, y) in zip(points, seen, strict=True):
        spot = (255 * np.exp(-((u - x) ** 2 + (v - y) ** 2) / 8)).astype(np.uint8)
        found = camera.color(np.repeat(spot[..., None], 3, axis=2))[..., 0].astype(float)
        centre = (u * found).sum() / found.sum(), (v * found).sum() / found.sum()
        np.testing.assert_allclose(centre, camera.model.project(point), atol=0.15)


def test_depths_are_moved_and_never_mixed() -> None:
    camera = PinholeCamera(calibration(LENS), 320, 240, rectified=False)
    depth = np.where(np.arange(320) < 160, 1000, 3000).astype(np.uint16) * np.ones((240, 1), np.uint16)
    assert set(np.unique(camera.depth(depth))) <= {0, 1000, 3000}


def test_a_rectified_picture_is_left_and_has_the_projections_camera() -> None:
    camera = PinholeCamera(calibration(LENS), 320, 240, rectified=True)
    assert not camera.undistorts
    assert (camera.model.fx, camera.model.cx, camera.model.cy) == (280.0, 150.0, 110.0)
    straight = PinholeCamera(calibration([0.0] * 5), 320, 240, rectified=False)
    assert not straight.undistorts
    assert straight.model.fx == 300.0


def test_a_smaller_picture_has_a_smaller_camera_that_sees_the_same() -> None:
    camera = PinholeCamera(calibration([]), 160, 120, rectified=False)
    large = PinholeCamera(calibration([]), 320, 240, rectified=False)
    point = np.array([0.2, -0.1, 1.0])
    np.testing.assert_allclose(camera.model.project(point) + 0.5, (large.model.project(point) + 0.5) / 2)
    with pytest.raises(ValueError, match="320 x 240 px, its pictures have 320 x 200"):
        PinholeCamera(calibration([]), 320, 200, rectified=False)


def test_without_a_calibration_a_kinects_view_is_assumed() -> None:
    camera = PinholeCamera(None, 640, 480, rectified=False).model
    assert 2 * np.degrees(np.arctan(320 / camera.fx)) == pytest.approx(57.0)


def test_depth_of_another_size_is_brought_to_the_colours() -> None:
    camera = PinholeCamera(calibration([]), 320, 240, rectified=False).model
    depth = np.arange(160 * 120, dtype=np.uint16).reshape(120, 160)
    found = fitted(depth, camera)
    assert found is not None
    assert found.shape == (240, 320)
    np.testing.assert_array_equal(found[::2, ::2], depth)
    assert fitted(np.zeros((200, 320), np.uint16), camera) is None
