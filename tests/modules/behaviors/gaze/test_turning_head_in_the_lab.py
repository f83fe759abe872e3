"""The head turns at 60 degrees a second: codes, faces, points of the cloud and obstacles of the costmap are where they
truly are, for each image has its own instant's pose. Another one's, 1/15 s off, would be 4 degrees beside.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import compiled, paths
from app.base.geometry import Pose2
from app.base.yaml_source import parse
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Faces, JointCommand, JointState, OccupancyGrid, PointCloud, QRCodes
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.robots.simulated.body import RobotSimulation
from app.robots.simulated.world import WORLD_GROUP
from app.robots.simulated.world_config import ObjectConfig, WorldConfig
from app.runtime.filter_bank import Pin
from tests.robots.conftest import needs_gl

ME = Source("operator", "a test")
POSTER, AT = "tour:robotics lab", np.array([11.1, 9.14, 1.25])
PERSON = (9.4, 8.7)
#: Lower than the laser, to the left of the way to the goal.
BOX, SIZE = (8.2, 7.6), (0.4, 0.3, 0.25)
GOAL = {"x": 0.8, "y": 0.3}
#: The head is taken to turn at full speed from this (rad/s) on: it is limited to 1.05.
FAST = 0.95
TWO_DEGREES = math.radians(2)
#: So many images of each kind are enough; the head turns for so long (s) at most to have them.
ENOUGH, STANDING_S, DRIVING_S = 10, 14.0, 20.0

SEEN_STANDING = ("code, kinect_optical_frame", "face, kinect_optical_frame", "cloud")


@dataclass
class Seen:
    """Angles (rad) beside the truth by what was seen, of images taken while the head turned fast."""

    beside: dict[str, list[float]] = field(default_factory=dict)

    def add(self, what: str, angle: float) -> None:
        self.beside.setdefault(what, []).append(angle)

    def enough(self, *what: str) -> bool:
        return all(len(self.beside.get(each, [])) >= ENOUGH for each in what)


class Speeds:
    """Speed of the pan joint at a stamp."""

    def __init__(self) -> None:
        self._joints: deque[tuple[float, float]] = deque(maxlen=300)

    def take(self, joints: JointState) -> None:
        self._joints.append((joints.stamp, joints.positions[joints.names.index("pan_joint")]))

    def fast(self, stamp: float) -> bool:
        near = [at for at in self._joints if abs(at[0] - stamp) < 0.07]
        if len(near) < 3:
            return False
        (begin, first), (end, last) = near[0], near[-1]
        return abs(last - first) / (end - begin) > FAST


def angle_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return math.acos(min(1.0, float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b))))


def depth_offset(physics: RobotSimulation, points_W: NDArray[np.float64], eye_W: NDArray[np.float64]) -> float:
    """The turn (rad) about the vertical through the eye that brings the points nearest to the world's surfaces."""
    groups = np.array([group == WORLD_GROUP for group in range(6)], dtype=np.uint8)
    geom = np.zeros(1, dtype=np.int32)
    rays = points_W - eye_W
    ranges = np.linalg.norm(rays, axis=1)

    def misfit(turn: float) -> float:
        c, s = math.cos(turn), math.sin(turn)
        turned = rays @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        off = []
        for ray, measured in zip(turned / ranges[:, None], ranges, strict=True):
            true = mujoco.mj_ray(physics.model, physics.data, eye_W, ray, groups, 1, -1, geom)
            off.append(min(abs(true - measured), 0.3) if true >= 0 else 0.3)
        return float(np.mean(off))

    turns = np.radians(np.arange(-5.0, 5.01, 0.5))
    return float(turns[int(np.argmin([misfit(turn) for turn in turns]))])


def outside_box(grid: OccupancyGrid, X_WO: Pose2, X_WB: Pose2) -> float | None:
    """By how much (rad, from the robot) obstacles near the box stick out beside it; None without any there."""
    rows, columns = np.nonzero(grid.cells >= 100)
    at = np.stack([columns, rows], axis=1).astype(np.float64) + 0.5
    cells_W = X_WO.transform(np.array(grid.origin) + grid.resolution_m * at)
    near = cells_W[np.linalg.norm(cells_W - np.array(BOX), axis=1) < 0.5]
    if len(near) == 0:
        return None
    corners = np.array(BOX) + np.array([[x * SIZE[0] / 2, y * SIZE[1] / 2] for x in (-1, 1) for y in (-1, 1)])
    X_BW = X_WB.inverse()
    cells, truth = X_BW.transform(near), X_BW.transform(corners)
    found, true = np.arctan2(cells[:, 1], cells[:, 0]), np.arctan2(truth[:, 1], truth[:, 0])
    cell = math.atan2(grid.resolution_m, float(np.linalg.norm(cells, axis=1).min()))
    return max(float(found.max() - true.max()), float(true.min() - found.min())) - cell


@needs_gl
@pytest.mark.slow
def test_what_is_seen_while_the_head_turns_is_where_it_truly_is(tmp_path: Path) -> None:
    compiled.make_ready()
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    robot = load_body(configuration.path(configuration.program.robot))
    assert isinstance(robot, RobotConfig)
    world = parse(robot.world, WorldConfig)
    box = ObjectConfig(kind="box", at=BOX, size=SIZE)
    person = {"name": "Ann", "face": "pilot", "at": list(PERSON), "script": [{"wait": 600, "look": "robot"}]}
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(yaml.safe_dump({"name": "one", "people": [person]}))
    start = robot.start.model_copy(update={"x": 11.0, "y": 7.7, "heading_deg": 135.0})
    streams = robot.streams.model_copy(update={"panorama": None})  # drawing it would take half of the time
    robot = robot.model_copy(update={"start": start, "scenario": scenario, "streams": streams})

    async def script(run: WorldRun) -> Seen:
        system, link, seen, speeds = run.system, run.link, Seen(), Speeds()
        simulation = link._simulation
        assert simulation is not None
        physics = simulation.physics
        link.attach("joints", speeds.take)

        def in_world(X_WB: Pose2, p_B: Any) -> NDArray[np.float64]:
            return np.asarray(X_WB.to_pose3().transform(np.asarray(p_B, np.float64)))

        def on_codes(message: QRCodes) -> None:
            for code in message.codes:
                if code.text == POSTER and code.p_BQ is not None and speeds.fast(message.stamp):
                    X_WB = link.true_pose()  # the robot stands
                    eye = in_world(X_WB, message.X_BC.translation)
                    seen.add(f"code, {message.frame}", angle_between(in_world(X_WB, code.p_BQ) - eye, AT - eye))

        def on_faces(message: Faces) -> None:
            for face in message.faces:
                if speeds.fast(message.stamp):
                    X_WB = link.true_pose()
                    (truth,) = link.people
                    middle = np.array(truth.mouth) + np.array([0.0, 0.0, 0.02 * truth.height_m])
                    eye = in_world(X_WB, message.X_BC.translation)
                    seen.add(f"face, {message.frame}", angle_between(in_world(X_WB, face.p_BF) - eye, middle - eye))

        def on_cloud(message: PointCloud) -> None:
            if speeds.fast(message.stamp) and not seen.enough("cloud"):
                points = message.points[:: max(1, len(message.points) // 300)].astype(np.float64)
                X_WB = link.true_pose()
                eye = in_world(X_WB, [0.08, 0.0, 1.3])  # within centimetres: the depths of points are metres
                seen.add("cloud", abs(depth_offset(physics, in_world(X_WB, points), eye)))

        def on_costmap(message: OccupancyGrid) -> None:
            beside = outside_box(message, link.start_pose, link.true_pose())
            if beside is not None:
                seen.add("costmap", max(beside, 0.0))

        for channel, take in (("qr_codes", on_codes), ("faces", on_faces), ("point_cloud", on_cloud)):
            system.graph.channel(channel).subscribe("test", capacity=1)
            system.graph.channel(channel).observe(take)
        await system.supervisor.started()

        async def swing(until: Any) -> None:
            """Turn the head between the two sides as fast as it can."""
            side = 1.0
            while not until():
                pan = physics.joint_positions()[list(physics.joints).index("pan_joint")]
                side = -side if pan * side > 0.9 else side
                link.command(JointCommand(system.clock.now(), "head", ("pan_joint", "tilt_joint"), (side, -0.1)))
                await system.clock.sleep(0.05)

        end = system.clock.now() + STANDING_S
        await swing(lambda: seen.enough(*SEEN_STANDING) or system.clock.now() >= end)
        system.graph.channel("local_costmap").subscribe("test", capacity=1)
        system.graph.channel("local_costmap").observe(on_costmap)
        system.workspace.add("GoTo", intensity=8, utility=1, params=GOAL, source=ME)
        end = system.clock.now() + DRIVING_S
        await swing(lambda: seen.enough("costmap") or system.clock.now() >= end)
        return seen

    pins = {name: Pin(1) for name in ("QRCodeDetector.images", "FaceDetector.images", "PointCloudBuilder.images")}
    seen = run_in_world(
        configuration,
        robot,
        script,
        world=world.model_copy(update={"objects": (*world.objects, box)}),
        cameras=True,
        pins=pins,
    )
    for what, angles in sorted(seen.beside.items()):
        median, most = math.degrees(np.median(angles)), math.degrees(max(angles))
        print(f"{what}: {len(angles)} images, {median:.2f} deg beside in the median, {most:.2f} at most")
    for what in (*SEEN_STANDING, "costmap"):
        assert len(seen.beside.get(what, [])) >= 5, what
        assert max(seen.beside[what]) <= TWO_DEGREES, what
