"""Reachable floor of the world by its own shapes (ground truth), for drawing goals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from app.base.geometry import Pose2
from app.robots.config import RobotConfig
from app.robots.simulated.body import build_simulation
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.world_config import WorldConfig

CELL_M = 0.05
_STEP_M = 0.02
"""Height (m) of shapes that the robot drives over: carpets, sills."""
_SHIFT = 4
_PARTS = 1 << _SHIFT


@dataclass(frozen=True, slots=True, eq=False)
class ReachableFloor:
    """The floor of a world, from its origin on, in cells of ``CELL_M``.

    ``room`` (rows along y, columns along x) float64: distance (m) from each cell's middle to the nearest shape that a
    body of that height touches, or to the floor's edge.
    """

    room: NDArray[np.float64]

    def reachable(self, start: Pose2, room_m: float) -> NDArray[np.bool_]:
        """The cells that a disc of radius ``room_m`` can reach from ``start``. Raises ValueError if there are none."""
        labels, _ = ndimage.label(self.room > room_m)
        here = labels[_cell(start.y), _cell(start.x)]
        if here == 0:
            raise ValueError(f"there is no room of {room_m:.2f} m around ({start.x:.1f}, {start.y:.1f})")
        return np.asarray(labels == here)

    def draw(
        self, cells: NDArray[np.bool_], count: int, start: Pose2, least_m: float, rng: np.random.Generator
    ) -> list[Pose2]:
        """``count`` places with any heading, spread over ``cells``, each at least ``least_m`` from the one before."""
        rows, columns = np.nonzero(cells)
        goals: list[Pose2] = []
        last = start
        while len(goals) < count:
            index = int(rng.integers(rows.size))
            x, y = (columns[index] + rng.random()) * CELL_M, (rows[index] + rng.random()) * CELL_M
            heading = float(rng.uniform(-math.pi, math.pi))
            if math.dist((x, y), (last.x, last.y)) >= least_m:
                last = Pose2(float(x), float(y), heading)
                goals.append(last)
        return goals


def survey(world: WorldConfig, robot: RobotConfig) -> ReachableFloor:
    """The floor of ``world`` for ``robot``, without people: every shape counts as its bounding box in plan view."""
    taken = filled(outlines(world, robot), (math.ceil(world.size[1] / CELL_M), math.ceil(world.size[0] / CELL_M)))
    room = ndimage.distance_transform_edt(np.pad(~taken, 1)) * CELL_M
    return ReachableFloor(np.asarray(room[1:-1, 1:-1]))


def outlines(world: WorldConfig, robot: RobotConfig) -> Iterator[NDArray[np.float64]]:
    """The corners (N, 2; m, plan view) of each shape's bounding box that ``robot`` would run into, without people."""
    base = TrueBase(robot.base.wheel_radius_m, robot.base.wheel_radius_m, robot.base.track_m)
    simulation = build_simulation(robot, world, base)
    model, data = simulation.model, simulation.data
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    for geom in np.flatnonzero((model.geom_bodyid == 0) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE)):
        corners = model.geom_aabb[geom, :3] + signs * model.geom_aabb[geom, 3:]
        corners = corners @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        if corners[:, 2].max() > _STEP_M and corners[:, 2].min() < robot.height_m:
            yield corners[:, :2]


def filled(shapes: Iterable[NDArray[np.float64]], size: tuple[int, int]) -> NDArray[np.bool_]:
    """Cells, ``size`` rows and columns from the origin on, that the convex ``shapes`` (corners (N, 2) in m) cover."""
    taken = np.zeros(size, dtype=np.uint8)
    for corners in shapes:
        outline = cv2.convexHull((corners / CELL_M * _PARTS).round().astype(np.int32))
        cv2.fillConvexPoly(taken, outline, 1, shift=_SHIFT)
    return taken.astype(np.bool_)


def _cell(place: float) -> int:
    return int(place / CELL_M)
