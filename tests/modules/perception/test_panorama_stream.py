"""The panorama for people: directions lie where the page looks for them."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from app.base.geometry import FisheyeModel, Pose3
from app.messages import EncodedImage, Image
from app.modules.perception.panorama_stream import PanoramaProjection, directions
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

LENS = FisheyeModel.from_fov(1024, 768, math.pi, math.pi)
#: Looks ahead, level; then turned to the left and tilted.
AHEAD = Pose3.from_translation_rpy((0.1, 0.0, 0.9), (-math.pi / 2, 0.0, -math.pi / 2))
ASIDE = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.2, 0.5)) @ AHEAD


def toward(azimuth: float, elevation: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    level = math.cos(elevation)
    return np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])


def with_dot(X_BC: Pose3, azimuth: float, elevation: float) -> np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]:
    """A grey fisheye image with a white dot in that direction of base_link."""
    color = np.full((768, 1024, 3), 60, np.uint8)
    u, v = LENS.project(toward(azimuth, elevation) @ X_BC.rotation)
    cv2.circle(color, (round(float(u)), round(float(v))), 7, (255, 255, 255), -1)
    return color


DIRECTIONS = [(0, 0), (45, 0), (-50, 0), (80, 0), (30, 40), (-20, -35), (0, 50)]


@pytest.mark.parametrize(
    ("X_BC", "azimuth_deg", "elevation_deg"),
    [*((AHEAD, *d) for d in DIRECTIONS), *((ASIDE, *d) for d in DIRECTIONS if d[0] > -40)],  # it sees no further right
)
def test_a_direction_is_found_where_its_angles_say(X_BC: Pose3, azimuth_deg: float, elevation_deg: float) -> None:
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    width, height = 640, 384
    picture = PanoramaProjection(width, height).unroll(with_dot(X_BC, azimuth, elevation), LENS, X_BC)
    white = np.argwhere(picture.min(axis=2) > 180) + 0.5
    y, x = white.mean(axis=0)
    assert x == pytest.approx(width * (0.5 - azimuth / math.pi), abs=1.0)
    assert y == pytest.approx(height / 2 - width * elevation / math.pi, abs=1.0)


def test_directions_are_unit_vectors_symmetric_about_straight_ahead() -> None:
    rays = directions(64, 38)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0)
    np.testing.assert_allclose(rays[:, ::-1] * (1, -1, 1), rays)
    np.testing.assert_allclose(rays[::-1] * (1, 1, -1), rays, atol=1e-15)


def test_what_the_lens_does_not_see_is_black() -> None:
    narrow = FisheyeModel.from_fov(400, 400, math.radians(100), math.radians(100))
    picture = PanoramaProjection(320, 160).unroll(np.full((400, 400, 3), 200, np.uint8), narrow, AHEAD)
    assert (picture[:, :60] == 0).all()
    assert (picture[80, 100:220] == 200).all()


def test_the_map_follows_a_camera_that_turns() -> None:
    unroller = PanoramaProjection(640, 384)
    for X_BC in (AHEAD, ASIDE, AHEAD):
        picture = unroller.unroll(with_dot(X_BC, 0.3, 0.2), LENS, X_BC)
        _, x = (np.argwhere(picture.min(axis=2) > 180) + 0.5).mean(axis=0)
        assert x == pytest.approx(640 * (0.5 - 0.3 / math.pi), abs=1.0)


def test_noise_of_encoders_costs_no_new_map_and_a_turning_head_does(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[Pose3] = []
    project = FisheyeModel.project

    def counting(self: FisheyeModel, points: np.ndarray) -> np.ndarray:
        computed.append(X_BC)
        return project(self, points)

    monkeypatch.setattr(FisheyeModel, "project", counting)
    unroller, image = PanoramaProjection(640, 384), np.zeros((768, 1024, 3), np.uint8)
    noise = np.random.default_rng(1)
    for _ in range(50):
        turn = 5e-4 * noise.standard_normal(3)
        X_BC = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (turn[0], turn[1], turn[2])) @ AHEAD
        unroller.unroll(image, LENS, X_BC)
    assert len(computed) == 1
    for degrees in (1.0, 2.0, 3.0):
        X_BC = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.radians(degrees))) @ AHEAD
        unroller.unroll(image, LENS, X_BC)
    assert len(computed) == 4


def test_the_module_makes_a_jpeg_of_each_image_with_the_desires_quality() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (768, 1024, 3)).astype(np.uint8)

    async def main() -> None:
        b = Bench(
            "app.modules.perception.panorama_stream:PanoramaStream",
            inputs={"images": Image},
            outputs={"pictures": EncodedImage},
        )
        async with b:
            pictures = b.listen("pictures")
            sizes = []
            for quality in (30, 80, 95):
                b.slot.configure({"jpeg_quality": quality, "max_points": 1000})
                b.feed("images", Image(4.0, "panorama_optical_frame", noise, None, LENS, AHEAD))
                picture = await pictures.receive()
                assert (picture.stamp, picture.frame) == (4.0, "panorama_optical_frame")
                assert (picture.width, picture.height) == (640, 384)
                shape = np.asarray(cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)).shape
                assert shape == (384, 640, 3)
                sizes.append(len(picture.jpeg))
            assert sizes == sorted(set(sizes)), "better quality, more bytes"
            assert b.slot.context.meter.cpu_ns > 0

    run_virtual(main())
