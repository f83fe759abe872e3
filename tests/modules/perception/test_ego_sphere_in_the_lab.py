"""What stands out in the simulated lab, through the whole program: a person who walks or claps, a coloured thing."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import unit_vector
from app.base.yaml_source import parse
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import SalientRegion, SalientRegions
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.robots.simulated.world_config import ObjectConfig, WorldConfig
from tests.robots.conftest import needs_gl

ME = Source("operator", "a test")
#: The robot looks west along the long corridor.
START = {"x": 12.0, "y": 8.0, "heading_deg": 180.0}
WITHIN_DEG = 15.0


def off_deg(run: WorldRun, message: SalientRegions, region: SalientRegion, points_W: NDArray[np.float64]) -> float:
    """Angle from a region to the nearest of the points (N, 3) of a thing, seen from the head; the robot stands."""
    X_WB = run.link.true_pose().to_pose3()
    v_W = points_W - X_WB.transform(np.array(message.p_BH))
    v_W /= np.linalg.norm(v_W, axis=1, keepdims=True)
    toward = X_WB.rotation @ unit_vector(region.azimuth, region.elevation)
    return math.degrees(math.acos(min(1.0, float((v_W @ toward).max()))))


def person_points(run: WorldRun, name: str) -> NDArray[np.float64]:
    """Points up the middle of a person."""
    (person,) = (each for each in run.link.people if each.name == name)
    return np.array([[person.x, person.y, z] for z in np.linspace(0.3, 0.95, 8) * person.height_m])


def run_lab(
    tmp_path: Path, people: list[dict[str, Any]], script: Any, *, red_box: bool = False, microphones: bool = False
) -> Any:
    """``script`` in the lab with ``people``, and perhaps a red box at the wall."""
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    robot = load_body(configuration.path(configuration.program.robot))
    assert isinstance(robot, RobotConfig)
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(yaml.safe_dump({"name": "saliency", "people": people}))
    robot = robot.model_copy(update={"start": robot.start.model_copy(update=START), "scenario": scenario})
    world = parse(robot.world, WorldConfig)
    if red_box:
        box = ObjectConfig(kind="pillar", at=(9.6, 7.2), size=(0.4, 0.4, 1.6), material="red")
        world = world.model_copy(update={"objects": (*world.objects, box)})
    return run_in_world(configuration, robot, script, world=world, cameras=True, microphones=microphones)


async def first_regions(run: WorldRun, seconds: float, gains: dict[str, float], *also: str) -> list[Any]:
    """Messages with at least a region, of ``seconds`` after the robot began to watch, with ``also`` desired."""
    found: list[SalientRegions] = []
    channel = run.system.graph.channel("salient_regions")
    channel.subscribe("test", capacity=1)
    for name in also:
        run.system.workspace.add(name, intensity=8, utility=1, source=ME)
    run.system.workspace.add("WatchSurroundings", intensity=8, utility=1, params=gains, source=ME)
    await run.system.clock.sleep(2.0)
    end = channel.observe(found.append)
    await run.system.clock.sleep(seconds)
    end()
    return found


@needs_gl
@pytest.mark.slow
def test_who_walks_while_the_rest_is_still_is_the_most_salient(tmp_path: Path) -> None:
    walker = {
        "name": "Ann",
        "face": "pilot",
        "at": [9.8, 9.0],
        "script": [{"walk": [9.8, 7.3], "speed": 0.8}, {"walk": [9.8, 9.0], "speed": 0.8}],
    }
    stands = {"name": "Bob", "face": "lecturer", "at": [8.2, 8.0], "script": [{"wait": 600, "look": "robot"}]}

    async def script(run: WorldRun) -> list[float]:
        off: list[float] = []
        observed = run.system.graph.channel("salient_regions").observe(
            lambda message: off.append(
                off_deg(run, message, message.regions[0], person_points(run, "Ann")) if message.regions else 180.0
            )
        )
        await first_regions(run, 4.0, {})
        observed()
        return off[10:]

    off = run_lab(tmp_path, [walker, stands], script)
    print(f"walking: {len(off)} messages, beside {np.percentile(off, [50, 90, 100]).round(1)} deg")
    assert len(off) >= 15
    assert float(np.median(off)) < WITHIN_DEG
    assert float(np.mean(np.array(off) < WITHIN_DEG)) > 0.9


@needs_gl
@pytest.mark.slow
def test_who_claps_behind_the_robot_is_the_most_salient(tmp_path: Path) -> None:
    claps = {
        "name": "Ann",
        "face": "pilot",
        "at": [14.0, 7.4],
        "script": [{"wait": 2}, {"clap": 20, "every": 0.5, "look": "robot"}],
    }

    async def script(run: WorldRun) -> list[float]:
        found = await first_regions(run, 3.5, {}, "LocateVoices", "DetectNoises")
        first = [(message, message.regions[0]) for message in found if message.regions]
        assert any(region.sounds > 0 for _, region in first)
        return [off_deg(run, message, region, person_points(run, "Ann")) for message, region in first if region.sounds]

    off = run_lab(tmp_path, [claps], script, microphones=True)
    print(f"clapping: {len(off)} messages, beside {np.percentile(off, [50, 90, 100]).round(1)} deg")
    assert len(off) >= 10
    assert float(np.median(off)) < WITHIN_DEG


@needs_gl
@pytest.mark.slow
def test_with_a_gain_for_colour_a_coloured_thing_is_the_most_salient(tmp_path: Path) -> None:
    walker = {
        "name": "Ann",
        "face": "pilot",
        "at": [9.8, 9.0],
        "shirt": [150, 150, 150],
        "trousers": [60, 60, 60],
        "script": [{"walk": [9.8, 8.2], "speed": 0.8}, {"walk": [9.8, 9.0], "speed": 0.8}],
    }
    red = np.array([[9.6, 7.2, z] for z in np.linspace(0.1, 1.5, 8)])

    async def script(run: WorldRun) -> list[float]:
        gains = {"motion": 0.0, "color": 1.0, "contrast": 0.0, "faces": 0.0, "sounds": 0.0}
        found = await first_regions(run, 3.0, gains)
        return [off_deg(run, message, message.regions[0], red) for message in found]

    off = run_lab(tmp_path, [walker], script, red_box=True)
    print(f"colour: {len(off)} messages, beside {np.percentile(off, [50, 90, 100]).round(1)} deg")
    assert len(off) >= 10
    assert max(off) < WITHIN_DEG
