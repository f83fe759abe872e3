"""People as sensors find them: the truth is the stage's, faces are found by a detector that knows nothing of it."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.messages import SceneTruth
from app.modules.perception.faces import yunet
from app.robots.config import RobotConfig, StartPose
from app.robots.guard import BaseVelocity
from app.robots.simulated.body import RobotSimulation, build_simulation
from app.robots.simulated.camera_rendering import KinectRenderer
from app.robots.simulated.kinect_noise import camera_model
from app.robots.simulated.laser import Laser
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.renderer import Renderer, WorldSnapshot, mocap_poses
from app.robots.simulated.scenery import gait
from app.robots.simulated.scenery.faces import FACES
from app.robots.simulated.scenery.people import PersonBodies, limb_poses
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState
from app.robots.simulated.world_config import WorldConfig
from app.robots.stream_config import KinectConfig
from tests.patience import PATIENCE_S
from tests.robots.conftest import needs_gl

AWAY = Pose2(-50.0, -50.0, 0.0)
MODEL = camera_model(KinectConfig())
START = StartPose(x=10.0, y=10.0, heading_deg=0.0)


def scenario_state(*people: dict[str, Any]) -> ScenarioState:
    named = [{"name": f"person {i}", "face": "pilot", **person} for i, person in enumerate(people)]
    return ScenarioState(ScenarioConfig.model_validate({"name": "test", "people": named}))


class Scene:
    """The robot in the hall with people, who can be put anywhere."""

    def __init__(self, robot: RobotConfig, world: WorldConfig, people: ScenarioState) -> None:
        self.scenario_state = people
        start = robot.model_copy(update={"start": START})
        self.simulation: RobotSimulation = build_simulation(start, world, TrueBase(0.10, 0.10, 0.44), people.actors)
        self.people = PersonBodies(self.simulation.model, people.actors)

    def put(self, number: int, distance: float, aside: float, facing_deg: float) -> None:
        """Person ``number`` ``distance`` ahead of the camera, looking ``facing_deg`` away from the robot's face."""
        actor = self.scenario_state.actors[number]
        actor.x, actor.y = START.x + 0.035 + distance, START.y + aside
        actor.heading = math.atan2(START.y - actor.y, START.x - actor.x) + math.radians(facing_deg)
        self.people.pose(self.simulation.data)
        self.simulation.step()


@pytest.fixture(scope="module")
def gallery(
    robot: RobotConfig, lab: WorldConfig, hall: WorldConfig
) -> Iterator[tuple[Scene, Renderer, KinectRenderer]]:
    """One person for each face, all far away."""
    scene = Scene(robot, hall, scenario_state(*({"face": face, "at": (3, 1 + i), "height_m": 1.6 + 0.08 * i}
                                       for i, face in enumerate(FACES))))  # fmt: skip
    renderer = Renderer(scene.simulation.model)
    yield scene, renderer, KinectRenderer(renderer, scene.simulation.model, KinectConfig(), np.random.default_rng(1))
    renderer.close()


def look(scene: Scene, eye: KinectRenderer, robot: RobotConfig) -> NDArray[np.uint8]:
    data = scene.simulation.data
    X_BC = load_model(robot.model).pose(KinectConfig().link)
    for _ in eye.draw(WorldSnapshot(0.0, data.qpos.copy(), mocap_poses(data), X_BC)):
        pass
    return np.ascontiguousarray(eye.picture[0])


def faces(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """YuNet's rows (n, 15) at the threshold that perceptions use."""
    detector = cv2.FaceDetectorYN.create(str(yunet.MODEL), "", (MODEL.width, MODEL.height), 0.8)
    found: object = detector.detect(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1]  # None of none, whatever the stubs say
    return np.zeros((0, 15), np.float32) if found is None else np.asarray(found, np.float32)


def projected_mouth(scene: Scene, number: int, robot: RobotConfig) -> NDArray[np.float64]:
    X_WC = scene.simulation.true_pose().to_pose3() @ load_model(robot.model).pose(KinectConfig().link)
    p_C = X_WC.inverse().transform(np.array(scene.scenario_state.actors[number].mouth))
    return np.array([MODEL.cx + MODEL.fx * p_C[0] / p_C[2], MODEL.cy + MODEL.fy * p_C[1] / p_C[2]])


@needs_gl
@pytest.mark.parametrize("face", FACES)
def test_a_face_is_found_where_the_truth_says_and_none_from_behind(
    gallery: tuple[Scene, Renderer, KinectRenderer], robot: RobotConfig, face: str
) -> None:
    scene, _, eye = gallery
    number = list(FACES).index(face)
    for distance, aside, facing in [
        (1.0, 0.0, 0), (2.0, 0.3, 20), (2.0, -0.3, -20), (2.0, 0.0, 40), (2.0, 0.0, -40), (3.0, 0.6, 0), (4.0, 0.0, 0),
    ]:  # fmt: skip
        scene.put(number, distance, aside, facing)
        found = faces(look(scene, eye, robot))
        assert len(found) == 1, (distance, facing)
        mouth = (found[0, 10:12] + found[0, 12:14]) / 2
        size = gait.EYES_SHARE - gait.MOUTH_SHARE
        tolerance = 0.5 * size * scene.scenario_state.actors[number].height_m * MODEL.fy / distance + 1.0
        assert math.dist(mouth, projected_mouth(scene, number, robot)) < tolerance, (distance, facing)
    for facing in (180, 140):
        scene.put(number, 2.0, 0.0, facing)
        assert len(faces(look(scene, eye, robot))) == 0, facing
    scene.put(number, -6.0, 0.0, 0)


@needs_gl
def test_who_moves_is_seen_to_move_though_the_robot_stands(
    gallery: tuple[Scene, Renderer, KinectRenderer], robot: RobotConfig
) -> None:
    scene, _, eye = gallery
    scene.put(0, 2.0, 0.0, 0)
    first, drawn = look(scene, eye, robot).copy(), eye.drawn
    look(scene, eye, robot)
    assert eye.drawn == drawn
    scene.put(0, 2.0, 0.1, 0)
    assert not np.array_equal(first, look(scene, eye, robot))
    assert eye.drawn == drawn + 1
    depth = 1 / eye.picture[1]
    assert depth[300, 320] == pytest.approx(2.0, abs=0.35)  # the trunk
    scene.put(0, -6.0, 0.0, 0)


def scan(scene: Scene, robot: RobotConfig) -> NDArray[np.float64]:
    """Points (n, 2) in the world that the laser sees nearer than the hall's walls."""
    config = robot.streams.hokuyo
    assert config is not None
    X_BL = load_model(robot.model).pose(config.link)
    laser = Laser(scene.simulation, config.model_copy(update={"sweep_s": 0.0}), X_BL, np.random.default_rng(1))
    laser.begin(0.0)
    got = laser.advance(0.0)
    assert got is not None
    angles = got.angle_min + got.angle_increment * np.arange(len(got.ranges))
    near = got.ranges < 6
    x = START.x + X_BL.translation[0] + got.ranges[near] * np.cos(angles[near])
    return np.column_stack([x, START.y + got.ranges[near] * np.sin(angles[near])])


def test_the_laser_sees_two_legs_where_the_truth_says(robot: RobotConfig, hall: WorldConfig) -> None:
    scene = Scene(robot, hall, scenario_state({"at": (12.5, 10.7), "heading_deg": 180.0, "height_m": 1.75}))
    scene.simulation.step()
    points = scan(scene, robot)
    assert len(points) > 6
    actor = scene.scenario_state.actors[0]
    for side in (1, -1):
        leg = (actor.x, actor.y - side * gait.HIP_ASIDE * 1.75)  # facing west: the left leg is in the south
        mine = points[(points[:, 1] - actor.y) * -side > 0]
        assert len(mine) > 2
        assert np.hypot(*(mine.mean(axis=0) - leg)) < 0.09
    walked = Scene(
        robot, hall, scenario_state({"at": (12.5, 10.7), "script": [{"walk": (12.5, 8.0)}], "repeat": False})
    )
    walked.scenario_state.advance(2.5, AWAY)
    walked.people.pose(walked.simulation.data)
    walked.simulation.step()
    middle = scan(walked, robot).mean(axis=0)
    assert math.dist(middle, (walked.scenario_state.actors[0].x, walked.scenario_state.actors[0].y)) < 0.2
    assert walked.scenario_state.actors[0].y < 9.5


def test_the_robot_cannot_drive_through_a_person(robot: RobotConfig, hall: WorldConfig) -> None:
    scene = Scene(robot, hall, scenario_state({"at": (11.2, 10.0), "heading_deg": 180.0}))
    for _ in range(2500):
        scene.simulation.drive(BaseVelocity(0.3, 0.0))
        scene.simulation.step()
    assert 10.2 < scene.simulation.true_pose().x < 10.85


def test_limbs_hang_together_in_every_posture() -> None:
    actor = scenario_state({"at": (0, 0), "height_m": 1.7}).actors[0]
    for gait_phase in np.linspace(0, 2 * math.pi, 9):
        for clap in (0.0, 1.0):
            joints = gait.joints(gait.Posture(gait=float(gait_phase), stride=1.0, clap=clap, apart=0.5))
            for side in ("left", "right"):
                hip, knee = joints[f"{side}_thigh"].at, joints[f"{side}_shin"].at
                assert math.dist(hip, knee) == pytest.approx(gait.THIGH)
                shoulder, elbow = joints[f"{side}_upper_arm"].at, joints[f"{side}_forearm"].at
                assert math.dist(shoulder, elbow) == pytest.approx(gait.UPPER_ARM)
            ankles = [
                joints[f"{side}_shin"].at[2] - gait.SHIN * math.cos(joints[f"{side}_shin"].pitch)
                for side in ("left", "right")
            ]
            standing = gait.HIP_SHARE - gait.THIGH - gait.SHIN
            assert min(ankles) == pytest.approx(standing, abs=1e-9)  # one foot stands, none is in the floor
    poses = limb_poses(actor)
    assert np.linalg.norm(poses[:, 3:], axis=1) == pytest.approx(np.ones(len(poses)))
    assert replace(actor.posture, stride=0.0) == gait.Posture()


@pytest.mark.slow
async def test_the_truth_of_a_running_world_is_the_scenarios(robot: RobotConfig, hall: WorldConfig) -> None:
    """Across the link's process: a walking person is reported as walking, at the given height, looking along the
    path."""
    blind = robot.streams.model_copy(update={"kinect": None, "panorama": None, "microphones": None, "hokuyo": None})
    walker = {"name": "walker", "face": "pilot", "at": (3, 3), "height_m": 1.81, "script": [{"walk": (9, 3)}]}
    scenario = ScenarioConfig.model_validate({"name": "test", "people": [walker | {"repeat": False}]})
    config = robot.model_copy(update={"streams": blind, "start": START})
    link = SimulatedLink(config, hall, 0.0, scenario)
    scenes: asyncio.Queue[SceneTruth] = asyncio.Queue()
    link.attach("scene_truth", scenes.put_nowait)
    link.demand("scene_truth", math.inf)
    async with asyncio.timeout(PATIENCE_S):
        await link.start()
        try:
            first = await scenes.get()
            while (last := await scenes.get()).people[0].x < first.people[0].x + 0.5:
                pass
        finally:
            await link.stop()
    [person] = last.people
    assert (person.name, person.height_m, person.y) == ("walker", 1.81, 3.0)
    assert person.heading == pytest.approx(0.0)
    assert person.mouth[0] - person.x == pytest.approx(gait.MOUTH_AHEAD * 1.81)
    seconds = last.stamp - first.stamp
    assert (last.people[0].x - first.people[0].x) / seconds < 1.1  # no faster than it walks, whatever the computer does
