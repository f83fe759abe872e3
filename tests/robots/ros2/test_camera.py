"""A camera's topics made into images. ROS's classes are stood for by plain objects with the same fields."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace as Fields
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from app.base import paths
from app.base.geometry import CameraModel
from app.base.joint_buffer import JointBuffer
from app.base.kinematic_model import KinematicModel, load_model
from app.logs.importers.ros_messages import Unreadable
from app.messages import Image
from app.robots.ros2.camera import CameraReader, CameraSetting

AT = 1_700_000_000.25
HEAD = "kinect_optical_frame"
WIDTH, HEIGHT = 64, 48


@pytest.fixture(scope="module")
def model() -> KinematicModel:
    return load_model(Path(paths.config_dir(), "robots", "irl1_tr.urdf"))


@pytest.fixture
def joints() -> JointBuffer:
    joints = JointBuffer()
    joints.add(AT - 0.05, {"pan_joint": 0.0})
    joints.add(AT + 0.05, {"pan_joint": 0.4})
    return joints


def raw(pixels: NDArray[Any], encoding: str) -> Fields:
    row = pixels.strides[0]
    data = pixels.tobytes()
    return Fields(
        height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, step=row, is_bigendian=0,
        data=np.frombuffer(data, np.uint8),
    )  # fmt: skip


def colors(seed: int = 0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)


def depths() -> NDArray[np.uint16]:
    return np.full((HEIGHT, WIDTH), 1500, np.uint16)


def info(distortion: float = 0.0, fx: float = 60.0) -> Fields:
    K = [fx, 0.0, 31.5, 0.0, fx, 23.5, 0.0, 0.0, 1.0]
    return Fields(
        width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", k=K, d=[distortion, 0.0, 0.0, 0.0, 0.0],
        p=[*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0],
    )  # fmt: skip


def reader(model: KinematicModel, joints: JointBuffer, **setting: Any) -> CameraReader:
    return CameraReader(CameraSetting(HEAD, 15.0, **setting), model, joints)


def test_a_picture_waits_for_its_calibration(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints)
    assert camera.picture(raw(colors(), "rgb8"), AT) is None
    camera.info(info(), AT)
    image = camera.picture(raw(colors(1), "rgb8"), AT)
    assert isinstance(image, Image)
    assert np.array_equal(image.color, colors(1))
    assert (image.stamp, image.frame, image.depth) == (AT, HEAD, None)
    assert (image.camera.fx, image.camera.cx, image.camera.width) == (60.0, 31.5, WIDTH)
    assert not image.color.flags.writeable


def test_its_pose_is_that_of_the_head_at_the_picture(model: KinematicModel, joints: JointBuffer) -> None:
    image = reader(model, joints, fov=math.radians(60)).picture(raw(colors(), "rgb8"), AT)
    assert image is not None
    assert np.allclose(image.X_BC.rotation, model.pose(HEAD, {"pan_joint": 0.2}).rotation)
    assert image.camera.fx == pytest.approx(0.5 * WIDTH / math.tan(math.radians(30)))


def test_without_the_joints_of_that_time_there_is_no_image(model: KinematicModel, joints: JointBuffer) -> None:
    assert reader(model, joints, fov=1.0).picture(raw(colors(), "rgb8"), AT + 1.0) is None


@pytest.mark.parametrize("depth_first", [False, True])
def test_depth_and_picture_of_one_time_are_one_image(
    model: KinematicModel, joints: JointBuffer, depth_first: bool
) -> None:
    camera = reader(model, joints, has_depth=True, fov=1.0)
    if depth_first:
        assert camera.depth(raw(depths(), "16UC1"), AT - 0.01) is None
        image = camera.picture(raw(colors(), "rgb8"), AT)
    else:
        assert camera.picture(raw(colors(), "rgb8"), AT) is None
        image = camera.depth(raw(depths(), "16UC1"), AT + 0.01)
    assert image is not None
    assert image.stamp == AT
    assert image.depth is not None
    assert np.array_equal(image.depth, depths())


def test_a_depth_of_another_picture_is_not_taken(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints, has_depth=True, fov=1.0)
    assert camera.depth(raw(depths(), "16UC1"), AT - 1 / 15) is None
    assert camera.picture(raw(colors(), "rgb8"), AT) is None
    assert camera.depth(raw(depths(), "16UC1"), AT) is not None


def test_metres_and_half_the_size_are_read(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints, has_depth=True, fov=1.0)
    metres = np.full((HEIGHT // 2, WIDTH // 2), 1.5, np.float32)
    metres[0, 0] = np.nan
    camera.depth(raw(metres, "32FC1"), AT)
    image = camera.picture(raw(colors(), "rgb8"), AT)
    assert image is not None
    assert image.depth is not None
    assert image.depth.shape == (HEIGHT, WIDTH)
    assert (image.depth[0, 0], image.depth[10, 10]) == (0, 1500)


def test_a_depth_of_another_shape_is_refused(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints, has_depth=True, fov=1.0)
    camera.depth(raw(np.zeros((WIDTH, WIDTH), np.uint16), "16UC1"), AT)
    with pytest.raises(Unreadable, match="a depth of 64 x 64 px is not registered to a picture of 64 x 48 px"):
        camera.picture(raw(colors(), "rgb8"), AT)


def test_a_compressed_picture_is_decoded(model: KinematicModel, joints: JointBuffer) -> None:
    grey = np.full((HEIGHT, WIDTH, 3), (200, 100, 50), np.uint8)
    coded = cv2.imencode(".png", cv2.cvtColor(grey, cv2.COLOR_RGB2BGR))[1]
    image = reader(model, joints, fov=1.0).picture(Fields(format="rgb8; png compressed bgr8", data=coded), AT)
    assert image is not None
    assert np.array_equal(image.color, grey)


def test_distorted_pictures_become_a_pinholes(model: KinematicModel, joints: JointBuffer) -> None:
    camera, plain = reader(model, joints), reader(model, joints, rectified=True)
    for each in (camera, plain):
        each.info(info(distortion=-0.3), AT)
    straightened, kept = (each.picture(raw(colors(), "rgb8"), AT) for each in (camera, plain))
    assert straightened is not None
    assert kept is not None
    assert np.array_equal(kept.color, colors())
    assert not np.array_equal(straightened.color, colors())


def test_a_changed_calibration_holds_from_the_next_picture_on(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints)
    for fx in (60.0, 80.0):
        camera.info(info(fx=fx), AT)
        image = camera.picture(raw(colors(), "rgb8"), AT)
        assert image is not None
        assert image.camera.fx == fx


def test_an_uncalibrated_camera_says_what_to_do(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints)
    camera.info(info(fx=0.0), AT)
    with pytest.raises(Unreadable, match="not calibrated; horizontal_fov_deg does without"):
        camera.picture(raw(colors(), "rgb8"), AT)


def test_a_calibration_of_another_size_is_refused(model: KinematicModel, joints: JointBuffer) -> None:
    camera = reader(model, joints)
    camera.info(Fields(**vars(info()) | {"width": 64, "height": 64}), AT)
    with pytest.raises(Unreadable, match="its CameraInfo is for 64 x 64 px"):
        camera.picture(raw(colors(), "rgb8"), AT)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_turned_pictures_show_the_same_rays(model: KinematicModel, joints: JointBuffer, quarters: int) -> None:
    def image(**setting: Any) -> Image:
        camera = reader(model, joints, has_depth=True, fov=1.0, **setting)
        camera.depth(raw(depths(), "16UC1"), AT)
        made = camera.picture(raw(colors(), "rgb8"), AT)
        assert made is not None
        return made

    as_it_lies, upright = image(), image(quarters=quarters)
    assert upright.color.shape[:2] == (upright.camera.height, upright.camera.width)
    assert upright.depth is not None
    assert as_it_lies.depth is not None
    assert not upright.color.flags.writeable
    for u, v in ((3, 5), (WIDTH - 1, 0)):
        lies = ray(as_it_lies, u, v)
        x, y = u, v
        for turn in range(quarters):
            height = HEIGHT if turn % 2 == 0 else WIDTH
            x, y = height - 1 - y, x
        assert np.allclose(ray(upright, x, y), lies)
        assert np.array_equal(upright.color[y, x], as_it_lies.color[v, u])
        assert upright.depth[y, x] == as_it_lies.depth[v, u]


def ray(image: Image, u: int, v: int) -> Any:
    """Where the pixel looks, in base_link."""
    camera = image.camera
    assert isinstance(camera, CameraModel)
    return image.X_BC.rotation @ ((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0)
