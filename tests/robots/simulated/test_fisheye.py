"""The panoramic camera: what is drawn lies where its model says, without seams, and posters can be read in it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import numpy as np
import pytest
import zxingcpp
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.base.kinematic_model import load_model
from app.robots.config import RobotConfig
from app.robots.simulated.body import build_simulation
from app.robots.simulated.camera_models import fisheye_model
from app.robots.simulated.camera_rendering import FisheyeRenderer
from app.robots.simulated.fisheye import tile
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.renderer import Renderer, WorldSnapshot
from app.robots.simulated.world import X_WP_of_page
from app.robots.simulated.world_config import (
    LETTER_HEIGHT_M,
    LETTER_WIDTH_M,
    PosterConfig,
    WorldConfig,
)
from app.robots.stream_config import PanoramicCameraConfig
from tests.robots.conftest import make_hall, needs_gl

CONFIG = PanoramicCameraConfig()
LENS = fisheye_model(CONFIG)


class Eye:
    """The panoramic camera of a robot that can be put anywhere."""

    def __init__(self, robot: RobotConfig, world: WorldConfig) -> None:
        simulation = build_simulation(robot, world, TrueBase(0.10, 0.10, 0.44))
        self.renderer = Renderer(simulation.model)
        self.panorama = FisheyeRenderer(self.renderer, simulation.model, CONFIG, np.random.default_rng(2))
        self.X_BC = load_model(robot.model).pose(CONFIG.link)
        self._initial = WorldSnapshot.initial(simulation.model)
        self._base = simulation.base_address

    def look(self, X_WB: Pose2) -> NDArray[np.uint8]:
        """The camera's picture with the base at ``X_WB``."""
        qpos = self._initial.qpos.copy()
        a = self._base
        qpos[a : a + 7] = [X_WB.x, X_WB.y, 0, math.cos(X_WB.theta / 2), 0, 0, math.sin(X_WB.theta / 2)]
        for _ in self.panorama.draw(WorldSnapshot(0.0, qpos, self._initial.mocap, self.X_BC)):
            pass
        color = np.zeros((CONFIG.height, CONFIG.width, 3), dtype=np.uint8)
        self.panorama.measure(color, None)
        return color

    def X_WC(self, X_WB: Pose2) -> Pose3:
        """The camera's pose with the base at ``X_WB``."""
        return X_WB.to_pose3() @ self.X_BC


def hall_with_poster(height: float) -> WorldConfig:
    """The empty hall with a poster in its middle, to be looked at from the west."""
    poster = PosterConfig(text="PANORAMA", title="Panorama", at=(10.0, 10.0), height=height, facing_deg=180.0)
    return make_hall().model_copy(update={"posters": (poster,)})


@pytest.fixture(scope="module")
def hall_eye(robot: RobotConfig) -> Iterator[Eye]:
    eye = Eye(robot, hall_with_poster(1.05))
    yield eye
    eye.renderer.close()


@pytest.fixture(scope="module")
def lab_eye(robot: RobotConfig, lab: WorldConfig) -> Iterator[Eye]:
    eye = Eye(robot, lab)
    yield eye
    eye.renderer.close()


def at_azimuth(eye: Eye, poster: PosterConfig, azimuth: float, distance: float) -> Pose2:
    """The base's pose with the camera ``distance`` (m) before ``poster``, seen at ``azimuth`` (rad, left positive)."""
    inwards = math.radians(poster.facing_deg) + math.pi
    heading = inwards - azimuth
    reach = eye.X_BC.translation
    eye_x = poster.at[0] - distance * math.cos(inwards)
    eye_y = poster.at[1] - distance * math.sin(inwards)
    c, s = math.cos(heading), math.sin(heading)
    return Pose2(eye_x - c * reach[0] + s * reach[1], eye_y - s * reach[0] - c * reach[1], heading)


def patch(color: NDArray[np.uint8], direction: NDArray[np.float64], focal: float, side: int) -> NDArray[np.uint8]:
    """A perspective picture of what ``color`` shows around ``direction`` (in the optical frame)."""
    lens = CameraModel(side, side, focal, focal, 0.5 * (side - 1), 0.5 * (side - 1))
    z = direction / np.linalg.norm(direction)
    x = np.cross((0.0, 1.0, 0.0), z)
    x /= np.linalg.norm(x)
    pixels = np.stack(np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float)), axis=-1)
    rays = lens.rays(pixels) @ np.column_stack((x, np.cross(z, x), z)).T
    at = LENS.project(rays).astype(np.float32)
    return np.asarray(cv2.remap(color, at[..., 0], at[..., 1], cv2.INTER_CUBIC), np.uint8)


def page_corners(poster: PosterConfig) -> NDArray[np.float64]:
    """Corners (4, 3) of the page in the world: upper left, upper right, lower right, lower left."""
    w, h = LETTER_WIDTH_M / 2, LETTER_HEIGHT_M / 2
    corners = np.array([(-w, h, 0.0005), (w, h, 0.0005), (w, -h, 0.0005), (-w, -h, 0.0005)])
    return X_WP_of_page(poster).transform(corners).astype(np.float64)


@needs_gl
@pytest.mark.parametrize("azimuth_deg", [0, 30, -44, 46, 60, -80, 80])
def test_a_posters_corners_are_where_the_model_says(hall_eye: Eye, azimuth_deg: int) -> None:
    poster = hall_with_poster(1.05).posters[0]
    base = at_azimuth(hall_eye, poster, math.radians(azimuth_deg), 1.0)
    grey = hall_eye.look(base).astype(np.float32).mean(axis=2)
    corners = LENS.project(hall_eye.X_WC(base).inverse().transform(page_corners(poster)))
    assert corners[1, 0] > corners[0, 0]  # not mirrored
    assert corners[3, 1] > corners[0, 1]  # not upside down
    # Along each side of the page, its edge is where the brightness halves from page to wall
    for i in range(4):
        a, b = page_corners(poster)[i], page_corners(poster)[(i + 1) % 4]
        inward = page_corners(poster).mean(axis=0) - (a + b) / 2
        offs = []
        for share in (0.1, 0.25, 0.75, 0.9):
            steps = np.linspace(-0.15, 0.07, 221)
            line = a + share * (b - a) + steps[:, None] * inward
            at = LENS.project(hall_eye.X_WC(base).inverse().transform(line)).astype(np.float32)
            values = cv2.remap(grey, at[:, 0], at[:, 1], cv2.INTER_LINEAR).ravel()
            outside, inside = values[:40].mean(), values[-15:].mean()
            edge = int(np.argmax((values - outside) / (inside - outside) > 0.5))
            offs.append(float(np.linalg.norm(at[edge] - at[np.argmin(np.abs(steps))])))
        assert np.mean(offs) < 1.0
        assert max(offs) < 2.0


@needs_gl
@pytest.mark.parametrize(("number", "azimuth_deg"), [(0, 0), (1, 0), (2, 25), (3, -60), (0, 75), (1, -80)])
def test_posters_are_read_at_about_a_metre(lab_eye: Eye, lab: WorldConfig, number: int, azimuth_deg: float) -> None:
    poster = lab.posters[number]
    base = at_azimuth(lab_eye, poster, math.radians(azimuth_deg), 1.0)
    direction = lab_eye.X_WC(base).inverse().transform(np.array(poster.p_WQ)).astype(np.float64)
    read: list[str] = []
    for _ in range(3):  # in one of three pictures at least: each has noise of its own
        found = zxingcpp.read_barcodes(patch(lab_eye.look(base), direction, 3 * LENS.fx, 480))
        read += [code.text for code in found]
    assert set(read) == {poster.text}


@needs_gl
def test_no_seam_shows_where_views_meet(lab_eye: Eye) -> None:
    color = lab_eye.look(Pose2(14.0, 10.2, 1.0)).astype(np.float32)
    columns, rows = np.meshgrid(np.arange(CONFIG.width, dtype=float), np.arange(CONFIG.height, dtype=float))
    rays = LENS.rays(np.stack((columns, rows), axis=-1))
    across = np.abs(np.diff(color.mean(axis=2), axis=1))
    owner = np.argmax(np.nan_to_num(np.abs(rays)), axis=2)
    within = ~(np.isnan(rays[:, 1:, 0]) | np.isnan(rays[:, :-1, 0]))
    seam = (np.diff(owner, axis=1) != 0) & within
    beside = np.roll(seam, 6, axis=1) & within
    assert seam.sum() > 500
    assert np.median(across[seam]) < 1.15 * np.median(across[beside]) + 0.3
    assert across[seam].mean() < 1.15 * across[beside].mean() + 0.3


@needs_gl
def test_the_lens_is_black_around_and_full_within(lab_eye: Eye) -> None:
    color = lab_eye.look(Pose2(11.1, 4.6, math.pi / 2))
    columns, rows = np.meshgrid(np.arange(CONFIG.width, dtype=float), np.arange(CONFIG.height, dtype=float))
    seen = ~np.isnan(LENS.rays(np.stack((columns, rows), axis=-1))[..., 0])
    assert (color[~seen] == 0).all()
    assert (color[seen].max(axis=1) < 10).mean() < 0.01
    assert 0.75 < seen.mean() < 0.79  # the circle fills the picture


@needs_gl
def test_a_still_robot_sees_the_same_picture_with_fresh_noise(lab_eye: Eye) -> None:
    here = Pose2(11.1, 4.6, 1.5)
    first = lab_eye.look(here)
    drawn = lab_eye.panorama.drawn
    again = lab_eye.look(here)
    assert lab_eye.panorama.drawn == drawn
    difference = again.astype(float) - first
    assert 1.5 < difference.std() < math.sqrt(2) * 2.2
    lab_eye.look(Pose2(11.1, 4.6, 1.501))
    assert lab_eye.panorama.drawn == drawn + 1


def test_views_take_little_more_than_the_pixels_they_are_for() -> None:
    tiling = tile(LENS)
    drawn = sum(piece.view.width * piece.view.height for piece in tiling.tiles)
    assert len(tiling.tiles) == 5
    assert drawn < 1.15 * LENS.width * LENS.height
    for piece in tiling.tiles:
        assert piece.x + piece.view.width <= tiling.width
        assert piece.y + piece.view.height <= tiling.height


def test_a_narrow_lens_needs_one_view() -> None:
    tiling = tile(FisheyeModel.from_fov(400, 300, math.radians(80), math.radians(60)))
    assert len(tiling.tiles) == 1
    assert tiling.tiles[0].view.right == pytest.approx(math.tan(math.radians(40)), abs=0.02)
