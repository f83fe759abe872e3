"""Rendered pictures: distances are true, posters can be read and located, the lab looks like a place."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
import zxingcpp
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.base.kinematic_model import load_model
from app.robots.config import RobotConfig
from app.robots.simulated.body import RobotSimulation, build_simulation
from app.robots.simulated.camera_rendering import KinectRenderer
from app.robots.simulated.kinect_noise import camera_model
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.renderer import Renderer, WorldSnapshot
from app.robots.simulated.world_config import WorldConfig
from app.robots.stream_config import KinectConfig
from tests.robots.conftest import make_hall, needs_gl

pytestmark = needs_gl
CONFIG = KinectConfig()
MODEL = camera_model(CONFIG)


class Eye:
    """A camera on a robot that can be put anywhere."""

    def __init__(self, robot: RobotConfig, world: WorldConfig) -> None:
        self.simulation: RobotSimulation = build_simulation(robot, world, TrueBase(0.10, 0.10, 0.44))
        self.renderer = Renderer(self.simulation.model)
        self.camera = KinectRenderer(self.renderer, self.simulation.model, CONFIG, np.random.default_rng(2))
        self.X_BC = load_model(robot.model).pose(CONFIG.link)
        self._initial = WorldSnapshot.initial(self.simulation.model)

    def look(self, X_WB: Pose2) -> tuple[NDArray[np.uint8], NDArray[np.uint16], NDArray[np.float32]]:
        """Measured colour and depth, and the true inverse depth, with the base at ``X_WB``."""
        qpos = self._initial.qpos.copy()
        a = self.simulation.base_address
        qpos[a : a + 7] = [X_WB.x, X_WB.y, 0, math.cos(X_WB.theta / 2), 0, 0, math.sin(X_WB.theta / 2)]
        for _ in self.camera.draw(WorldSnapshot(0.0, qpos, self._initial.mocap, self.X_BC)):
            pass
        color = np.zeros((CONFIG.height, CONFIG.width, 3), dtype=np.uint8)
        depth = np.zeros((CONFIG.height, CONFIG.width), dtype=np.uint16)
        self.camera.measure(color, depth)
        return color, depth, self.camera.picture[1]

    def X_WC(self, X_WB: Pose2) -> Pose3:
        """The camera's pose with the base at ``X_WB``."""
        return X_WB.to_pose3() @ self.X_BC


@pytest.fixture(scope="module")
def eye(robot: RobotConfig, lab: WorldConfig) -> Iterator[Eye]:
    eye = Eye(robot, lab)
    yield eye
    eye.renderer.close()


def test_depth_to_a_known_wall(robot: RobotConfig) -> None:
    eye = Eye(robot, make_hall())
    try:
        for distance in (1.0, 2.5, 4.0):
            base = Pose2(19.9 - distance - float(eye.X_BC.translation[0]), 10.0, 0.0)
            _, depth, inverse = eye.look(base)
            assert inverse[240, 320] == pytest.approx(1 / distance, rel=2e-4)
            window = depth[150:250, 220:420].astype(float)
            assert window[window > 0].mean() / 1000 == pytest.approx(distance, abs=0.002 + 0.002 * distance**2)
            assert (window > 0).mean() > 0.98
            # the wall is flat: the same depth along the axis everywhere
            assert inverse[100:300, 50:590].std() < 1e-3
    finally:
        eye.renderer.close()


def in_front_of(eye: Eye, lab: WorldConfig, number: int, distance: float, aside: float = 0.0) -> Pose2:
    """The base's pose that has the camera ``distance`` before poster ``number``, ``aside`` metres to the left."""
    poster = lab.posters[number]
    facing = math.radians(poster.facing_deg)
    forward = math.atan2(-math.sin(facing), -math.cos(facing))
    reach = distance + float(eye.X_BC.translation[0])
    at = Pose2(*poster.at, forward) @ Pose2(-reach, aside, 0.0)
    return Pose2(at.x, at.y, forward)


# The first poster can be seen down a corridor, the others hang where there are 2.2 m to stand
@pytest.mark.parametrize(
    ("number", "distance"), [(0, 2.5), (0, 2.25), *((n, d) for n in range(4) for d in (0.8, 1.2, 1.6, 2.0))]
)
def test_posters_are_read_and_located_face_on(eye: Eye, lab: WorldConfig, number: int, distance: float) -> None:
    base = in_front_of(eye, lab, number, distance)
    color, depth, _ = eye.look(base)
    codes = zxingcpp.read_barcodes(color)
    assert [code.text for code in codes] == [lab.posters[number].text]
    corners = np.array(
        [
            (p.x, p.y)
            for p in (
                codes[0].position.top_left, codes[0].position.top_right,
                codes[0].position.bottom_right, codes[0].position.bottom_left,
            )
        ]
    )  # fmt: skip
    assert corners[0, 0] < corners[1, 0]  # not mirrored
    assert corners[0, 1] < corners[3, 1]  # not upside down
    (left, top), (right, bottom) = corners.min(axis=0).astype(int), corners.max(axis=0).astype(int)
    region = depth[top:bottom, left:right].astype(float) / 1000
    center = MODEL.back_project(corners.mean(axis=0), np.array(region[region > 0].mean()))
    located = eye.X_WC(base).transform(center)
    assert math.dist(located, lab.posters[number].p_WQ) < 0.05


def test_a_poster_is_read_from_aside(eye: Eye, lab: WorldConfig) -> None:
    color, _, _ = eye.look(in_front_of(eye, lab, 0, 1.3, aside=0.35))
    assert [code.text for code in zxingcpp.read_barcodes(color)] == [lab.posters[0].text]


@pytest.mark.parametrize(
    "pose",
    [
        (11.1, 4.6, 90),
        (1.5, 8.0, 0),
        (20.0, 7.6, 175),
        (14.0, 10.2, 60),
        (2.5, 10.4, 50),
        (8.5, 5.5, 215),
        (13.5, 4.5, -30),
    ],
)
def test_the_lab_looks_like_a_place(eye: Eye, pose: tuple[float, float, float]) -> None:
    color, depth, _ = eye.look(Pose2(pose[0], pose[1], math.radians(pose[2])))
    grey = color.mean(axis=2)
    assert 70 < grey.mean() < 190  # neither night nor fog
    assert grey.std() > 20
    assert (grey > 250).mean() < 0.10
    assert (grey < 12).mean() < 0.10
    across, down = np.abs(np.diff(grey, axis=1)), np.abs(np.diff(grey, axis=0))
    tiles = [
        (across[r : r + 60, c : c + 80].mean() + down[r : r + 60, c : c + 79].mean())
        for r in range(0, 420, 60)
        for c in range(0, 560, 80)
    ]
    assert np.median(tiles) > 2.0
    assert (depth > 0).mean() > 0.05


def test_the_robot_does_not_see_itself_looking_ahead(eye: Eye) -> None:
    _, _, inverse = eye.look(Pose2(11.1, 4.6, math.pi / 2))
    assert inverse.max() < 1.0


def test_a_still_robot_sees_the_same_picture_with_fresh_noise_and_a_moved_one_another(eye: Eye) -> None:
    here, aside = Pose2(11.1, 4.6, 1.5), Pose2(11.1, 4.601, 1.5)
    first, _, first_depth = eye.look(here)
    drawn = eye.camera.drawn
    again, _, again_depth = eye.look(here)
    assert eye.camera.drawn == drawn
    np.testing.assert_array_equal(first_depth, again_depth)
    assert not np.array_equal(first, again)
    _, _, moved_depth = eye.look(aside)
    assert eye.camera.drawn == drawn + 1
    assert not np.array_equal(first_depth, moved_depth)
