"""Faces of simulated people, rendered as the robot's cameras see them, against where those people truly are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose2
from app.base.kinematic_model import load_model
from app.messages import Image
from app.modules.perception.faces.face_position import FaceLocator, FaceSighting
from app.modules.perception.faces.face_tracks import FaceTracks
from app.modules.perception.faces.yunet import THRESHOLD
from app.robots.config import RobotConfig, load_robot_config
from app.robots.simulated.body import build_simulation
from app.robots.simulated.camera_models import fisheye_model
from app.robots.simulated.camera_rendering import CameraRenderer, FisheyeRenderer, KinectRenderer
from app.robots.simulated.kinect_noise import camera_model
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.renderer import Renderer, WorldSnapshot, mocap_poses
from app.robots.simulated.scenery.people import PersonBodies
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState
from tests.robots.conftest import CONFIG, make_hall, needs_gl

pytestmark = [pytest.mark.slow, needs_gl]

HERE = Pose2(5.0, 5.0, 0.0)
Make = Callable[..., "World"]


class World:
    """A hall with people who play their scripts, and the robot's two cameras in it, wherever the robot is put."""

    def __init__(self, robot: RobotConfig, people: Sequence[dict[str, Any]]) -> None:
        named = [{"name": f"person {number}", **person} for number, person in enumerate(people)]
        self.scenario_state = ScenarioState(ScenarioConfig.model_validate({"name": "faces", "people": named}))
        self._simulation = build_simulation(robot, make_hall(), TrueBase(0.1, 0.1, 0.44), self.scenario_state.actors)
        self._people = PersonBodies(self._simulation.model, self.scenario_state.actors)
        self.renderer = Renderer(self._simulation.model)
        kinect, panorama = robot.streams.kinect, robot.streams.panorama
        assert kinect is not None
        assert panorama is not None
        model, links = self._simulation.model, load_model(robot.model)
        self._kinect = KinectRenderer(self.renderer, model, kinect, np.random.default_rng(1))
        self._panorama = FisheyeRenderer(self.renderer, model, panorama, np.random.default_rng(2))
        self._lenses: dict[str, CameraModel | FisheyeModel] = {}
        self._lenses = {"kinect": camera_model(kinect), "panorama": fisheye_model(panorama)}
        self._X_BC = {"kinect": links.pose(kinect.link), "panorama": links.pose(panorama.link)}
        self._initial = WorldSnapshot.initial(model)

    def look(self, camera: str, X_WB: Pose2) -> Image:
        """What ``kinect`` or ``panorama`` sees now, with the robot at ``X_WB``."""
        self._people.pose(self._simulation.data)
        qpos, base = self._initial.qpos.copy(), self._simulation.base_address
        qpos[base : base + 7] = [X_WB.x, X_WB.y, 0, math.cos(X_WB.theta / 2), 0, 0, math.sin(X_WB.theta / 2)]
        lens, X_BC = self._lenses[camera], self._X_BC[camera]
        color = np.zeros((lens.height, lens.width, 3), np.uint8)
        depth = np.zeros((lens.height, lens.width), np.uint16) if camera == "kinect" else None
        eye: CameraRenderer = self._kinect if camera == "kinect" else self._panorama
        for _ in eye.draw(WorldSnapshot(0.0, qpos, mocap_poses(self._simulation.data), X_BC)):
            pass
        eye.measure(color, depth)
        return Image(self.scenario_state.time_s, camera, color, depth, lens, X_BC)

    def faces(self, X_WB: Pose2) -> list[NDArray[np.float64]]:
        """Where the middles of the faces truly are (3,), in ``base_link``: 0.02 of the height above the mouth."""
        X_BW = X_WB.to_pose3().inverse()
        above = np.array((0.0, 0.0, 0.02))
        middles = [np.array(p.mouth) + p.height_m * above for p in self.scenario_state.people]
        return [X_BW.transform(middle).astype(np.float64) for middle in middles]


@pytest.fixture
def make() -> Iterator[Make]:
    robot = load_robot_config(CONFIG / "robots" / "irl1_tr.yaml")
    worlds: list[World] = []

    def world(*people: dict[str, Any]) -> World:
        worlds.append(World(robot, people))
        worlds[-1].scenario_state.advance(2.0, HERE)
        return worlds[-1]

    yield world
    for made in worlds:
        made.renderer.close()


@pytest.fixture(scope="module")
def looker() -> FaceLocator:
    return FaceLocator(THRESHOLD)


def standing(face: str, azimuth: float, distance: float, **more: Any) -> dict[str, Any]:
    """A person ``distance`` (m) from the robot at ``HERE``, who looks at it."""
    at = (HERE.x + distance * math.cos(azimuth), HERE.y + distance * math.sin(azimuth))
    heading = math.degrees(azimuth) + 180
    return {"face": face, "at": at, "heading_deg": heading, "script": [{"wait": 99, "look": "robot"}], **more}


def beside(sighting: FaceSighting, truth: NDArray[np.float64]) -> float:
    """Angle (rad) between the sighting's ray and the one to ``truth``."""
    towards = truth - sighting.origin
    return math.acos(min(1.0, float(sighting.ray @ towards) / float(np.linalg.norm(towards))))


def paired(
    sightings: Sequence[FaceSighting], truths: Sequence[NDArray[np.float64]]
) -> list[tuple[FaceSighting, NDArray[np.float64]]]:
    return [(s, min(truths, key=lambda truth: beside(s, truth))) for s in sightings]


def test_the_kinect_finds_everybody_within_centimetres(make: Make, looker: FaceLocator) -> None:
    crowd = [("pilot", -0.35, 1.2), ("lecturer", -0.12, 2.0), ("programmer", 0.12, 3.0), ("visitor", 0.35, 4.0)]
    world = make(*(standing(*person) for person in crowd))
    pairs = paired(looker.look(world.look("kinect", HERE), 640, 400), world.faces(HERE))
    assert len(pairs) == 4
    for sighting, truth in pairs:
        assert sighting.measured
        assert np.linalg.norm(sighting.p_BF - truth) < 0.04


def test_the_panorama_finds_everybody_around_and_knows_how_far_within_its_deviation(
    make: Make, looker: FaceLocator
) -> None:
    crowd = [("pilot", -1.4, 2.5), ("lecturer", -0.6, 1.2), ("programmer", 0.3, 3.0), ("visitor", 1.35, 2.0)]
    world = make(*(standing(*person) for person in crowd))
    pairs = paired(looker.look(world.look("panorama", HERE), None, 400), world.faces(HERE))
    assert len(pairs) == 4
    for sighting, truth in pairs:
        assert math.degrees(beside(sighting, truth)) < 1.0
        deviation = sighting.p_BF - truth
        assert deviation @ np.linalg.solve(sighting.covariance, deviation) < 16


def test_people_taller_and_smaller_than_supposed_are_as_far_off_as_said(make: Make, looker: FaceLocator) -> None:
    """1.50 m and 1.95 m are 2.1 and 2.4 deviations from the mean."""
    world = make(standing("pilot", -0.5, 2.0, height_m=1.50), standing("visitor", 0.5, 2.0, height_m=1.95))
    for sighting, truth in paired(looker.look(world.look("panorama", HERE), None, 400), world.faces(HERE)):
        error = sighting.range_m - float(np.linalg.norm(truth - sighting.origin))
        assert 1.2 < abs(error) / sighting.range_sigma_m < 4


def test_a_walker_keeps_his_number_past_a_bystander_over_both_cameras_while_the_robot_turns(
    make: Make, looker: FaceLocator
) -> None:
    across = [{"wait": 2, "look": "robot"}, {"walk": (HERE.x + 2.2, HERE.y - 1.6), "speed": 1.4, "look": "robot"}]
    walker = {"face": "lecturer", "at": (HERE.x + 2.2, HERE.y + 1.2), "heading_deg": -90, "script": across}
    world = make(standing("programmer", -0.1, 3.2), walker)
    tracks = FaceTracks()
    numbers: dict[int, list[int]] = {0: [], 1: []}
    errors = []
    for shot in range(18):
        time_s = 2.0 + 0.1 * shot
        world.scenario_state.advance(time_s, HERE)
        X_WB = Pose2(HERE.x, HERE.y, 0.3 - 0.04 * shot)
        camera = ("panorama", "kinect", "kinect")[shot % 3]
        image = world.look(camera, X_WB)
        sightings = looker.look(image, 640, 400)
        truths = world.faces(X_WB)
        for sighting, placed in zip(
            sightings, tracks.see(image.stamp, camera, sightings, X_WB.to_pose3()), strict=True
        ):
            who = min((0, 1), key=lambda i: beside(sighting, truths[i]))
            numbers[who].append(placed.track)
            errors.append(float(np.linalg.norm(placed.p_BF - truths[who])) if shot > 6 else 0.0)
    assert [len(set(seen)) for seen in numbers.values()] == [1, 1]
    assert set(numbers[0]) != set(numbers[1])
    assert min(len(seen) for seen in numbers.values()) > 10
    assert max(errors) < 0.25, "also in the panorama, once the Kinect has measured their heights"
