"""Controllers that follow a path among obstacles: what one choice costs, and how fast and how near they drive.

Courses of random posts (diameter 0.15 m) 8 m long, known beforehand and planned through, each driven by every
controller with two bodies: the Jackal (2 m/s, 20 choices a second) and the lab's robot (0.4 m/s, 10 a second), which
obey their accelerations and nothing else. The peer is the Dynamic Window Approach with the settings published for the
BARN challenge, on the same courses. CPU time is one core's. Last, worlds of the challenge itself, crossed by the
whole program in the simulated world with each controller, if the reference data is there: `hbba experiment barn` does
all of them.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.link import BaseLimits
from app.messages import OccupancyGrid
from app.modules.behaviors.navigation.controller import BodyModel, DistanceField, MotionState
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostSettings, cost_field
from app.modules.behaviors.navigation.planning.goal_planning import plan
from app.modules.behaviors.navigation.planning.reference_path import ReferencePath
from app.modules.behaviors.navigation.tracking.control_cycle import CONTROLLERS, controller_named
from app.robots.actuator_config import circle
from benchmarks.report import Row, benchmark_main, row

BENCHMARK = "controllers"
PEER = "dwa_published"
WIDTH_M, LENGTH_M, CELL_M, POST_M = 4.5, 10.0, 0.025, 0.075
LIMIT_S = 60.0
WORLDS = ("31", "100", "211", "263")


@dataclass(frozen=True, slots=True)
class Rider:
    """A body on the courses: its footprint, limits, and how often it chooses."""

    name: str
    footprint: tuple[tuple[float, float], ...]
    limits: BaseLimits
    period_s: float


RIDERS = (
    Rider(
        "2 m/s",
        ((0.254, -0.215), (0.254, 0.215), (-0.254, 0.215), (-0.254, -0.215)),
        BaseLimits(2.0, 4.0, 4.0, 12.0),
        0.05,
    ),
    Rider("0.4 m/s", circle(0.28), BaseLimits(0.4, 1.0, 0.4, 4.0), 0.1),
)


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """Posts (N, 2) m, the field around them, and the way through (M, 3)."""

    posts: NDArray[np.float64]
    field: DistanceField
    way: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Ride:
    """What came of one: s to the end (inf: never), least m from a post, and the CPU s of each choice."""

    time_s: float
    nearest_m: float
    choices: list[float]


def course(seed: int, rider: Rider) -> Course:
    """Posts through which the planner finds a way; deterministic."""
    footprint = Footprint.polygon(np.array(rider.footprint))
    while True:
        random = np.random.default_rng(seed)
        posts = random.uniform((0.2, 1.5), (WIDTH_M - 0.2, LENGTH_M - 1.5), (int(random.integers(15, 40)), 2))
        rows, columns = round(LENGTH_M / CELL_M), round(WIDTH_M / CELL_M)
        free = np.full((rows, columns), 255, dtype=np.uint8)
        cv2.rectangle(free, (0, 0), (columns - 1, rows - 1), 0)
        for x, y in posts:
            cv2.circle(free, (int(x / CELL_M), int(y / CELL_M)), round(POST_M / CELL_M), 0, -1)
        grid = OccupancyGrid(0.0, "map", np.where(free == 0, 100, 0).astype(np.int8), CELL_M, (0.0, 0.0), 1)
        costs = cost_field(grid, footprint, (), CostSettings())
        found = plan(costs, Pose2(WIDTH_M / 2, 0.8, math.pi / 2), Pose2(WIDTH_M / 2, LENGTH_M - 0.8, math.nan))
        if found.code == "way":
            distances = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(CELL_M)
            return Course(posts, DistanceField(np.ascontiguousarray(distances), (0.0, 0.0), CELL_M), found.poses)
        seed += 1000


def ride(driven: Course, name: str, rider: Rider) -> Ride:
    """Drive the course with a controller."""
    limits, controller = rider.limits, controller_named(name)
    body = BodyModel.of(rider.footprint, limits, padding_m=0.03 if name == PEER else 0.0)
    track = ReferencePath(driven.way, speed_mps=limits.linear_mps, braking_mps2=limits.linear_mps2)
    motion = MotionState(Pose2(*driven.way[0]), 0.0, 0.0)
    choices: list[float] = []
    nearest, now = math.inf, 0.0
    while now < LIMIT_S:
        if track.come_to(motion.pose)[0] < 0.2:
            return Ride(now, nearest, choices)
        way = track.ahead(Pose2(), max(2.5, 3.0 * limits.linear_mps))
        begin = time.thread_time()
        choice = controller.choose(motion, driven.field, way, body, rider.period_s)
        choices.append(time.thread_time() - begin)
        for _ in range(10):
            motion = _moved(motion, choice.linear_mps, choice.angular_radps, limits, rider.period_s / 10)
        nearest = min(nearest, _distance(driven.posts, motion.pose, rider))
        now += rider.period_s
    return Ride(math.inf, nearest, choices)


def rows(courses: int, worlds: Sequence[str]) -> list[Row]:
    """Every row."""
    found = []
    for rider in RIDERS:
        driven = [course(seed, rider) for seed in range(courses)]
        rides = {name: [ride(one, name, rider) for one in driven] for name in CONTROLLERS}
        for name in CONTROLLERS:
            found += _compared(f"{name}, {rider.name}", rides[name], rides[PEER], name == PEER)
    return found + _barn(worlds)


def _compared(case: str, ours: list[Ride], peer: list[Ride], is_peer: bool) -> list[Row]:
    def one(metric: str, unit: str, mine: list[float], theirs: list[float]) -> Row:
        beside = {} if is_peer or not theirs else {"peer": theirs, "peer_name": "DWA, published"}
        return row(BENCHMARK, case, metric, unit, mine, **beside)  # type: ignore[arg-type]

    def choice(rides: list[Ride], share: float) -> list[float]:
        return [1e3 * float(np.quantile(r.choices, share)) for r in rides]

    arrived = [(a.time_s, b.time_s) for a, b in zip(ours, peer, strict=True) if max(a.time_s, b.time_s) < math.inf]
    got_through = [100.0 * sum(r.time_s < math.inf and r.nearest_m > 0 for r in ours) / len(ours)]
    found = [
        one("one choice, CPU, median", "ms", choice(ours, 0.5), choice(peer, 0.5)),
        one("one choice, CPU, p99", "ms", choice(ours, 0.99), choice(peer, 0.99)),
        one("courses passed without touching", "%", got_through, []),
        one("nearest to a post", "m", [r.nearest_m for r in ours], [r.nearest_m for r in peer]),
    ]
    if arrived:
        found.append(one("time, where both passed", "s", [a for a, _ in arrived], [b for _, b in arrived]))
    return found


def _barn(worlds: Sequence[str]) -> list[Row]:
    folder = Path(os.environ.get("HBBA_REFERENCE_DATA", Path(__file__).resolve().parents[1] / ".." / "shared" / "data"))
    file = folder / "barn" / "worlds.json"
    if not worlds or not file.is_file():
        return []
    from app.experiments.barn.trial import Trial, cross
    from app.experiments.barn.worlds import chosen, load_worlds

    known = load_worlds(file)
    config = config_dir() / "jackal.yaml"
    found: dict[str, list[float]] = {}
    for name in ("mppi", PEER):
        overrides: dict[str, dict[str, object]] = {"PlanAndFollowPath": {"controller": name}}
        results = [cross(Trial(config, world, 2.0, overrides=overrides)) for world in chosen(known, ",".join(worlds))]
        found[name] = [result.score for result in results]
    case = f"BARN, worlds {', '.join(worlds)}"
    return [row(BENCHMARK, case, "score, at most 0.5", "", found["mppi"], found[PEER], "DWA, published")]


def _moved(motion: MotionState, linear: float, angular: float, limits: BaseLimits, time_s: float) -> MotionState:
    v = motion.linear_mps + _within(linear - motion.linear_mps, limits.linear_mps2 * time_s)
    w = motion.angular_radps + _within(angular - motion.angular_radps, limits.angular_radps2 * time_s)
    return MotionState(MotionState(motion.pose, v, w).after(time_s).pose, v, w)


def _within(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _distance(posts: NDArray[np.float64], pose: Pose2, rider: Rider) -> float:
    corners = np.array(rider.footprint)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    x, y = posts[:, 0] - pose.x, posts[:, 1] - pose.y
    points = np.stack((c * x + s * y, c * y - s * x), axis=1).astype(np.float32)
    outline = corners.astype(np.float32).reshape(-1, 1, 2)
    return min(-cv2.pointPolygonTest(outline, (float(u), float(v)), True) for u, v in points) - POST_M


def main() -> int:
    """Measure, and print the table."""
    return benchmark_main(__doc__, lambda quick: rows(2 if quick else 12, () if quick else WORLDS))


if __name__ == "__main__":
    sys.exit(main())
