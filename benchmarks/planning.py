"""Planning on whole maps, and the local costmap: the time of each, alone in one thread.

Ways on maps of 50 x 50 m at 0.05 m between random free places: empty, a building of rooms along corridors, random
posts, a single lane of 2.3 km (serpentine), and a goal walled off, for which everything else is searched. CPU time is
what it costs; time passes as the computer's other work lets it.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image, LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.inflation import CostField, cost_field, with_obstacles
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings, LocalCostmap
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import (
    PersistentObstacleLayer,
    PersistentObstacleSettings,
)
from app.modules.behaviors.navigation.planning.goal_planning import check_path, plan
from app.robots.actuator_config import circle
from benchmarks.report import Row, benchmark_main, row

SIDE = 1000
BODY = Footprint.polygon(np.array(circle(0.28)))


def measure(quick: bool) -> Sequence[Row]:
    """Every figure; ``quick``: a few samples of each."""
    count = 12 if quick else 150
    rows: list[Row] = []
    for case, cells, lane in (
        ("empty", _walled(), None),
        ("rooms", _rooms(), None),
        ("posts", _posts(), None),
        ("serpentine", _serpentine(), (Pose2(-24.5, -24.5, 0.0), Pose2(24.0, 24.5, math.nan))),
        ("unreachable", _cut_off(), (Pose2(-24.0, -24.0, 0.0), Pose2(24.4, 24.0, math.nan))),
    ):
        rows += _ways(case, cells, lane, count)
    rows += _fields(count)
    rows += _around(count)
    return rows


def _ways(case: str, cells: NDArray[np.int8], lane: tuple[Pose2, Pose2] | None, count: int) -> list[Row]:
    field = cost_field(_grid(cells), BODY)
    rng = np.random.default_rng(1)
    pairs = [lane or (_place(field, rng), _place(field, rng)) for _ in range(count)]
    for begin, goal in pairs[:3]:
        plan(field, begin, goal)
    taken = [_take(partial(plan, field, begin, goal)) for begin, goal in pairs]
    return _rows("planning", f"way, {case}", taken)


def _fields(count: int) -> list[Row]:
    cells, rng = _rooms(), np.random.default_rng(2)
    grid = _grid(cells)
    field = cost_field(grid, BODY)
    changed = cells.copy()
    changed[480:500, 490:520] = 100
    points = rng.uniform(-2, 2, (300, 2))
    goal = _place(field, rng)
    way = next(found for found in (plan(field, _place(field, rng), goal) for _ in range(50)) if len(found.poses) > 200)
    pose = Pose2(*way.poses[0])
    rows: list[Row] = []
    works: dict[str, Callable[[], object]] = {
        "costs, whole map": lambda: cost_field(grid, BODY),
        "costs, 1 x 1.5 m changed": lambda: cost_field(_grid(changed), BODY, previous=field),
        "costs, 300 temporary obstacles": lambda: with_obstacles(field, points),
        "is the path still free": lambda: check_path(field, way.poses, pose),
    }
    for case, work in works.items():
        work()
        rows += _rows("planning", case, [_take(work) for _ in range(count)])
    return rows


def _around(count: int) -> list[Row]:
    """A robot that drives along a wall among posts, 720 beams and 640 x 480 depth, at the Kinect's angle of view."""
    rows: list[Row] = []
    angles = np.linspace(-math.pi / 2, math.pi / 2, 720)
    camera = CameraModel(640, 480, 589.4, 609.3, 319.5, 239.5)
    X_BC = Pose3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0.04, 0.0, 1.4]))
    X_BC = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.2, 0.0)) @ X_BC
    rng = np.random.default_rng(3)
    ahead = np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1)
    rays = camera.back_project(ahead, np.ones(ahead.shape[:2])) @ X_BC.rotation.T
    with np.errstate(divide="ignore"):
        floor = np.where(rays[..., 2] < 0, -X_BC.translation[2] / rays[..., 2], np.inf)
    depth_m = np.minimum(floor, 2.0 + 0.5 * np.sin(ahead[..., 0] / 40.0))
    for size_m, memory_m in ((4.0, 8.0), (8.0, 12.0)):
        here = LocalCostmap(BODY, 1.5, CostmapSettings(size_m=size_m, memory_m=memory_m))
        things = PersistentObstacleLayer(BODY, 1.5, PersistentObstacleSettings(every_s=0.0))
        times: tuple[list[Taken], ...] = ([], [], [], [])
        for k in range(count + 5):
            stamp, pose = 0.05 * k, Pose2(0.02 * k, 0.0, 0.2 * math.sin(0.1 * k))
            ranges = np.minimum(2.0 / np.maximum(np.abs(np.sin(angles)), 1e-3), 3.0 + 2.0 * np.sin(9.0 * angles))
            ranges = (ranges + rng.normal(0, 0.01, 720)).astype(np.float32)
            X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))
            scan = LaserScan(stamp, "laser", ranges, ranges, -math.pi / 2, math.pi / 719, 0.1, 30.0, 0.0125, X_BL)
            noisy = 1000.0 * depth_m + rng.normal(0, 4.0, depth_m.shape)
            depth = np.where(noisy < 5000.0, noisy, 0.0).astype(np.uint16)
            image = Image(stamp, "kinect", np.zeros((1, 1, 3), np.uint8), depth, camera, X_BC)
            works: tuple[Callable[[], object], ...] = (
                partial(here.add_scan, scan, pose),
                partial(here.add_depth, image, pose),
                partial(here.around, pose, stamp),
                partial(things.look, image, pose, np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))),
            )
            for taken, work in zip(times, works, strict=True):
                taken.append(_take(work))
        for what, taken in zip(("scan", "depth picture", "distances", "remembering a picture"), times, strict=True):
            rows += _rows("local costmap", f"{what}, {size_m:g} m", taken[5:])
    return rows


#: CPU time and time, ms.
Taken = tuple[float, float]


def _rows(benchmark: str, case: str, taken: list[Taken]) -> list[Row]:
    cpu, passed = ([one[k] for one in taken] for k in range(2))
    return [
        row(benchmark, case, "CPU time", "ms", cpu),
        row(benchmark, case, "CPU time, p99", "ms", [float(np.percentile(cpu, 99))]),
        row(benchmark, case, "time, p99", "ms", [float(np.percentile(passed, 99))]),
    ]


def _take(work: Callable[[], object]) -> Taken:
    cpu, began = time.process_time(), time.perf_counter()
    work()
    return 1e3 * (time.process_time() - cpu), 1e3 * (time.perf_counter() - began)


def _grid(cells: NDArray[np.int8]) -> OccupancyGrid:
    return OccupancyGrid(0.0, "map", cells, 0.05, (-25.0, -25.0), 0)


def _place(field: CostField, rng: np.random.Generator) -> Pose2:
    while True:
        row, column = rng.integers(0, SIDE, 2).tolist()
        if np.isfinite(field.cost[row, column]):
            return Pose2(*field.frame.middle(row, column), math.nan)


def _walled() -> NDArray[np.int8]:
    cells = np.zeros((SIDE, SIDE), dtype=np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    return cells


def _rooms() -> NDArray[np.int8]:
    """Corridors 2.5 m wide, rooms of 5 x 6.25 m on both sides, a door and some furniture in each."""
    cells, rng = _walled(), np.random.default_rng(0)
    for corridor in range(100, SIDE - 100, 300):
        for wall, room in (
            (corridor, slice(corridor - 120, corridor)),
            (corridor + 50, slice(corridor + 50, corridor + 170)),
        ):
            cells[wall : wall + 2] = 100
            for left in range(0, SIDE, 100):
                cells[max(room.start, 0) : room.stop, left : left + 2] = 100
                door = left + int(rng.integers(10, 70))
                cells[wall : wall + 2, door : door + 20] = 0
                for _ in range(3):
                    r, c = room.start + int(rng.integers(10, 90)), left + int(rng.integers(10, 80))
                    cells[max(r, 0) : r + int(rng.integers(8, 20)), c : c + int(rng.integers(8, 20))] = 100
    return cells


def _posts() -> NDArray[np.int8]:
    cells, rng = _walled(), np.random.default_rng(0)
    for r, c in rng.integers(10, SIDE - 10, (1200, 2)):
        cells[r : r + 3, c : c + 3] = 100
    return cells


def _serpentine() -> NDArray[np.int8]:
    cells = _walled()
    for k in range(1, 49):
        cells[20 * k, (20 if k % 2 else 1) : (SIDE - 1 if k % 2 else SIDE - 20)] = 100
    return cells


def _cut_off() -> NDArray[np.int8]:
    cells = _posts()
    cells[:, SIDE - 30] = 100
    cells[:, SIDE - 25 : SIDE - 1] = 0
    return cells


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
