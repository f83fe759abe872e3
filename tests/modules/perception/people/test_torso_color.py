"""The colours of a torso: taken below the face by every camera, alike in other light, unlike for other clothes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.messages import Image
from app.modules.perception.people.torso_color import BINS, distance, histogram, torso_pixels

PINHOLE = CameraModel.from_vertical_fov(320, 240, 0.75)
FISHEYE = FisheyeModel.from_fov(512, 384, np.pi, np.pi)
#: Looks ahead from 1.25 m above the floor.
X_BC = Pose3(np.array(((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0))), np.array((0.1, 0.0, 1.25)))
ORANGE, GREEN = (196, 88, 52), (40, 160, 60)
Color = tuple[int, int, int]


def scene(camera: CameraModel | FisheyeModel, at: tuple[float, float], shirt: Color) -> Image:
    """A shirt of 0.9 to 1.4 m height before a green wall, on the plane x = ``at[0]`` about y = ``at[1]``."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = camera.rays(np.stack((u, v), axis=-1)) @ X_BC.rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        met = X_BC.translation + (at[0] - X_BC.translation[0]) / rays[..., :1] * rays
        on = (rays[..., 0] > 0) & (np.abs(met[..., 1] - at[1]) < 0.2) & (met[..., 2] > 0.9) & (met[..., 2] < 1.4)
    color = np.where(on[..., None], np.array(shirt), np.array(GREEN)).astype(np.uint8)
    return Image(0.0, "camera", color=color, depth=None, camera=camera, X_BC=X_BC)


def flat(rgb: Color) -> NDArray[np.float32]:
    return histogram(np.full((50, 3), rgb, np.uint8))


@pytest.mark.parametrize("camera", [PINHOLE, FISHEYE])
def test_the_torso_is_below_the_face_in_every_camera(camera: CameraModel | FisheyeModel) -> None:
    for at in ((2.0, 0.0), (2.0, 0.5)):
        pixels = torso_pixels(scene(camera, at, ORANGE), (*at, 1.6))
        assert pixels is not None
        assert (pixels == ORANGE).all(axis=1).mean() > 0.9


def test_a_torso_outside_the_image_has_no_colours() -> None:
    assert torso_pixels(scene(PINHOLE, (0.5, 0.0), ORANGE), (0.5, 0.0, 1.6)) is None
    assert torso_pixels(scene(FISHEYE, (2.0, 0.0), ORANGE), (-2.0, 0.0, 1.6)) is None


def test_the_wall_behind_is_left_out_where_depth_is_measured() -> None:
    image = scene(PINHOLE, (2.0, 0.0), ORANGE)
    shirt = (image.color == ORANGE).all(axis=-1)
    depth = np.where(shirt, 1900, 4000).astype(np.uint16)
    pixels = torso_pixels(Image(0.0, "camera", image.color, depth, PINHOLE, X_BC), (2.0, 0.1, 1.6))
    assert pixels is not None
    assert (pixels == ORANGE).all()


def test_histograms_differ_by_clothes_and_little_by_light() -> None:
    assert flat(ORANGE).shape == (BINS,)
    assert flat(ORANGE).sum() == pytest.approx(1)
    darker = tuple(round(0.9 * c) for c in ORANGE)
    assert distance(flat(ORANGE), flat(ORANGE)) == pytest.approx(0, abs=1e-3)
    assert distance(flat(ORANGE), flat((darker[0], darker[1], darker[2]))) < 0.2
    for other in ((74, 92, 132), (226, 224, 216), (62, 104, 92), (20, 20, 20)):
        assert distance(flat(ORANGE), flat(other)) > 0.6
