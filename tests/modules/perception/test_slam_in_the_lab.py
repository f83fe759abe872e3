"""SLAM2D in the simulated lab: a map driven by hand, its walls where the world's are; kept, and found again on it."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base import compiled, paths
from app.base.geometry import Pose2
from app.base.yaml_source import parse
from app.experiments.script import Waypoint, drive_script
from app.experiments.world_run import WorldRun, run_in_world, with_settings
from app.maps.library import MapLibrary
from app.messages import Localization
from app.program.config import Configuration, load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.robots.simulated.world_config import WorldConfig
from app.runtime.filter_bank import Pin

LAB = paths.config_dir() / "lab.yaml"
#: No more than it takes: a test has little time.
MODULES = ("Hokuyo", "WheelOdometry", "SLAM2D", "Teleop", "MobileBaseControl", "ScenarioCoordinator")
PINS = {"SLAM2D.scans": Pin(4)}
DRIVE = [Waypoint(go=(11.0, 8.0)), Waypoint(go=(9.2, 8.0))]


def lab() -> Configuration:
    configuration = load_configuration(LAB)
    modules = {name: configuration.program.modules[name] for name in MODULES}
    return replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Virtual time waits for no compiler."""
    compiled.make_ready()


def body(x: float = 11.0, y: float = 4.6, heading_deg: float = 90.0) -> RobotConfig:
    configuration = load_configuration(LAB)
    robot = load_body(configuration.path(configuration.program.robot))
    assert isinstance(robot, RobotConfig)
    start = robot.start.model_copy(update={"x": x, "y": y, "heading_deg": heading_deg})
    return robot.model_copy(update={"start": start, "scenario": None})


def wall_distances(grid_x: NDArray[np.float64], grid_y: NDArray[np.float64], world: WorldConfig) -> NDArray[np.float64]:
    """How far each point is from the nearest face of the outside walls and of those of the corridors."""
    found = np.full(len(grid_x), np.inf)
    for wall in world.walls:
        a, b = np.array(wall.start), np.array(wall.end)
        along = (b - a) / np.linalg.norm(b - a)
        points = np.stack((grid_x, grid_y), axis=1) - a
        at, off = points @ along, np.abs(points @ np.array([-along[1], along[0]]))
        inside = (at > 0) & (at < np.linalg.norm(b - a))
        found = np.where(inside, np.minimum(found, np.abs(off - wall.thickness / 2)), found)
    return found


@pytest.mark.slow
def test_the_lab_is_mapped_kept_and_found_again(tmp_path: Path) -> None:
    library = MapLibrary(tmp_path)
    robot = body()
    start = Pose2(robot.start.x, robot.start.y, math.radians(robot.start.heading_deg))

    async def drive_and_keep(run: WorldRun) -> list[float]:
        await run.system.supervisor.started()
        errors: list[float] = []

        def judge(place: Localization) -> None:
            off = (start @ place.X_MB).inverse() @ run.link.true_pose()
            errors.append(math.hypot(off.x, off.y))

        run.system.graph.channels["localization"].observe(judge)
        await drive_script(run.system, DRIVE)
        await run.system.map.server.save("lab")
        return errors

    errors = run_in_world(lab(), robot, drive_and_keep, maps=library, pins=PINS)
    assert max(errors) < 0.08
    grid = library.grid("lab")
    rows, columns = np.nonzero(grid.cells >= 65)
    x, y = ((v + 0.5) * grid.resolution_m + o for v, o in zip((columns, rows), grid.origin, strict=True))
    c, s = math.cos(start.theta), math.sin(start.theta)
    distances = wall_distances(start.x + c * x - s * y, start.y + s * x + c * y, parse(robot.world, WorldConfig))
    on_walls = distances[distances < 0.25]
    assert len(on_walls) > 500
    assert np.mean(on_walls) < 0.04, "walls stand where the world's do"

    # Another day: it is put down elsewhere, and the program begins with the map.
    other = body(9.6, 7.8, 180.0)

    async def find_itself(run: WorldRun) -> tuple[float, Sequence[str], float]:
        explained_each: list[Localization] = []
        run.system.graph.channels["localization"].observe(explained_each.append)
        await run.system.supervisor.started()
        began = run.system.clock.now()
        driving = asyncio.create_task(drive_script(run.system, [Waypoint(go=(8.0, 8.0))]))
        await driving
        found = next(place.stamp for place in explained_each if place.state == "tracking") - began
        off = (start @ explained_each[-1].X_MB).inverse() @ run.link.true_pose()
        return found, [place.state for place in explained_each], math.hypot(off.x, off.y)

    begins = with_settings(lab(), {"SLAM2D": {"map": "lab"}})
    found_s, states, error = run_in_world(begins, other, find_itself, maps=library, pins=PINS)
    assert found_s < 10.0
    assert states == sorted(states), "searching, then tracking, and never back"
    assert error < 0.08
