"""How many low objects navigation knows before the robot is near: with a level head, and looking where it goes.

The robot is driven through the rooms of the lab, along the tour of ``config/scenarios/mapping.yaml`` but for three legs
that show it low objects on purpose. Those are what is lower than the laser, from 5 cm up: boxes, crates, suitcases,
bins, stools, a low table. One is known once two cells of the persistent obstacles lie on its outline (within 8 cm). Of
those that the robot comes within 1 m of (from the middle of its base to the outline), it is known in time if it was
known before. In lockstep, without panorama and people; the peer is the level head.
"""

from __future__ import annotations

import asyncio
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from app.robots.simulated.gl import gl_environment

os.environ.update(gl_environment())  # read when MuJoCo is imported

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import compiled
from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.base.yaml_source import parse
from app.experiments.goals.goal_run import UNCONCERNED, body_in, seeing
from app.experiments.script import Waypoint, drive_script, load_script
from app.experiments.world_run import WorldRun, run_in_world
from app.modules.behaviors.plan_and_follow_path import PlanAndFollowPath
from app.program.config import load_configuration
from app.robots.simulated.scenery.furniture import usual_size
from app.robots.simulated.world_config import ObjectConfig, WorldConfig
from app.runtime.filter_bank import Pin
from benchmarks.report import Row, benchmark_main, row

LASER_M, LOWEST_M = 0.40, 0.05
NEAR_M = 1.0
ON_OUTLINE_M = 0.08
ENOUGH_CELLS = 2
PERIOD_S = 0.2
PICTURES_HZ = 5.0
SHOWN = ("towards the suitcase", "towards the crate", "towards the box by the door")
ME = Source("operator", "the benchmark")


@dataclass
class LowObject:
    """A low object of the world: ``outline`` (length, width) m about ``place``. ``known_m``: how far away the robot was
    when it was known; ``nearest_m``: how near it has come; ``in_time``: whether it was known within ``NEAR_M``."""

    name: str
    place: Pose2
    outline: tuple[float, float]
    known_m: float | None = None
    nearest_m: float = math.inf
    in_time: bool | None = None

    def distances(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (N,) m of points (N, 2) in the world from the outline; 0 inside."""
        at = np.abs(self.place.inverse().transform(points))
        out = np.maximum(at - np.array(self.outline) / 2, 0.0)
        return np.asarray(np.hypot(out[:, 0], out[:, 1]))

    def observe(self, robot: Pose2, obstacles: NDArray[np.float64]) -> None:
        """The robot is at ``robot`` and knows the ``obstacles`` (N, 2), both in the world."""
        away = float(self.distances(np.array([[robot.x, robot.y]]))[0])
        if self.known_m is None and int((self.distances(obstacles) <= ON_OUTLINE_M).sum()) >= ENOUGH_CELLS:
            self.known_m = away
        self.nearest_m = min(self.nearest_m, away)
        if self.in_time is None and away < NEAR_M:
            self.in_time = self.known_m is not None


def low_objects(world: WorldConfig) -> list[LowObject]:
    """What the laser passes over."""
    return [_low(each) for each in world.objects if LOWEST_M <= each.z + _size(each)[2] < LASER_M]


def _size(each: ObjectConfig) -> tuple[float, float, float]:
    return each.size or usual_size(each.kind)


def _low(each: ObjectConfig) -> LowObject:
    length, width, _ = _size(each)
    x, y = each.at
    return LowObject(f"{each.kind} at {x:g}, {y:g}", Pose2(x, y, math.radians(each.yaw_deg)), (length, width))


def tour(quick: bool) -> tuple[Waypoint, ...]:
    """The legs that are driven."""
    legs = load_script(config_dir() / "scenarios" / "mapping.yaml")
    plain = tuple(leg for leg in legs if not leg.label.startswith(SHOWN))
    return plain[:6] if quick else plain


def drive(looking: bool, quick: bool) -> list[LowObject]:
    """The objects after the tour; ``looking``: with a desire LookWhereGoing."""
    compiled.make_ready()
    config = config_dir() / "lab.yaml"
    body = seeing(body_in(config, None)).model_copy(update={"ground_truth": True})
    kinect = body.streams.kinect
    assert kinect is not None
    slow = body.streams.model_copy(update={"kinect": kinect.model_copy(update={"rate_hz": PICTURES_HZ})})
    body = body.model_copy(update={"streams": slow})
    objects = low_objects(parse(body.world, WorldConfig))

    async def script(run: WorldRun) -> None:
        system = run.system
        for cls in ("SLAM", "Teleoperation", *(["LookWhereGoing"] if looking else [])):
            system.workspace.add(cls, intensity=8, utility=1, source=ME)
        await system.clock.sleep(3.0)
        watching = asyncio.create_task(_watch(run, objects))
        await drive_script(system, tour(quick), lambda number, _: print(f"leg {number + 1}", end=" ", flush=True))
        watching.cancel()
        print()

    pins = dict.fromkeys(("PlanAndFollowPath.images", "PlanAndFollowPath.scans"), Pin(1))
    run_in_world(load_configuration(config), body, script, cameras=True, without=UNCONCERNED, pins=pins)
    return objects


async def _watch(run: WorldRun, objects: Sequence[LowObject]) -> None:
    module = run.system.graph.modules["PlanAndFollowPath"].context.instance
    assert isinstance(module, PlanAndFollowPath)
    layer = module._control.persistent_obstacles
    assert layer is not None
    while True:
        points = await module.compute(getattr, layer, "points")
        # The map begins where the robot did.
        obstacles = run.link.start_pose.transform(points) if len(points) else np.empty((0, 2))
        for each in objects:
            each.observe(run.link.true_pose(), obstacles)
        await run.system.clock.sleep(PERIOD_S)


def measure(quick: bool) -> Sequence[Row]:
    """Both tours."""
    level, going = drive(looking=False, quick=quick), drive(looking=True, quick=quick)
    print(f"{'low object':<28}{'nearest':>9}{'known from, level':>19}{'going':>8}   (m)")
    for one, other in zip(level, going, strict=True):
        print(f"{one.name:<28}{one.nearest_m:>9.2f}{_known(one):>19}{_known(other):>8}")
    near = [(one, other) for one, other in zip(level, going, strict=True) if one.in_time is not None]
    near = [(one, other) for one, other in near if other.in_time is not None]
    counts = [float(sum(bool(pair[side].in_time) for pair in near)) for side in (0, 1)]
    seen = [float(sum(each.known_m is not None for each in side)) for side in (level, going)]
    peer = "level head"
    return [
        row(
            "low_objects",
            f"{len(near)} passed within {NEAR_M:g} m",
            "known before",
            "objects",
            counts[1:],
            counts[:1],
            peer,
        ),
        row("low_objects", f"{len(level)} in the lab", "known at the end", "objects", seen[1:], seen[:1], peer),
    ]


def _known(each: LowObject) -> str:
    if each.known_m is None:
        return "never"
    late = each.in_time is False
    return f"{each.known_m:.2f}{' late' if late else ''}"


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
