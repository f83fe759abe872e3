"""The laser: ray casting from the robot's pose at each ray's time, with the Hokuyo's noise.

A sweep takes time. Its rays are cast in a few fans, each in the middle of the time in which its rays really leave, so
a scan taken while turning is as skewed as the real one's. Intensities are 1000 at 1 m face-on, falling with distance
and angle of incidence.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.messages import LaserScan
from app.robots.config import HokuyoConfig
from app.robots.simulated.body import PREFIX, RobotSimulation
from app.robots.simulated.scenery.people import LASER_GROUP
from app.robots.simulated.world import OUT_OF_REACH_GROUP, WORLD_GROUP

FAN_S = 0.0035
"""Longest duration of one fan of rays: at 1 rad/s the base turns less than one ray's step in it."""
_MARGIN_RAD = math.radians(1.0)
"""Pitch and roll of the base, which tilt the fan."""
REACH_M = 0.25
"""Greatest deviation of rays from the laser's plane by tilt; shapes beyond are omitted."""


class Laser:
    """Makes scans of a simulation; :meth:`begin` one, then :meth:`advance` until it is whole."""

    def __init__(self, simulation: RobotSimulation, config: HokuyoConfig, X_BL: Pose3, rng: Generator) -> None:
        self._simulation = simulation
        self._config = config
        self._X_BL = X_BL
        self._rng = rng
        self._body = simulation.model.body(PREFIX + config.link).id
        fov = math.radians(config.fov_deg)
        self._angle_min = -fov / 2
        self._increment = fov / (config.rays - 1)
        angles = self._angle_min + self._increment * np.arange(config.rays)
        self._directions_L = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
        self._groups = np.array([group in (WORLD_GROUP, LASER_GROUP) for group in range(6)], dtype=np.uint8)
        _leave_out_of_reach(simulation, float(X_BL.translation[2]))
        self._sight = _RayTargets(simulation)
        fans = max(1, math.ceil(config.sweep_s / FAN_S))
        self._fans = np.linspace(0, config.rays, fans + 1).astype(int)
        self._distances = np.zeros(config.rays)
        self._normals = np.zeros((config.rays, 3))
        self._directions_W = np.zeros((config.rays, 3))
        self._geoms = np.zeros(config.rays, dtype=np.int32)
        self._cast_fans = fans
        self._stamp = 0.0

    @property
    def sweeping(self) -> bool:
        return self._cast_fans < len(self._fans) - 1

    def begin(self, stamp: float) -> None:
        """Start a sweep whose first ray leaves at ``stamp``."""
        self._cast_fans = 0
        self._stamp = stamp

    def advance(self, stamp: float) -> LaserScan | None:
        """Cast the fans whose middle has come at ``stamp``; return the scan when it is whole."""
        fans = len(self._fans) - 1
        due = math.floor((stamp - self._stamp) / self._config.sweep_s * fans + 0.5) if self._config.sweep_s else fans
        for fan in range(self._cast_fans, min(due, fans)):
            self._cast(int(self._fans[fan]), int(self._fans[fan + 1]))
            self._cast_fans = fan + 1
        return None if self.sweeping else self._scan()

    def _cast(self, first: int, last: int) -> None:
        data = self._simulation.data
        rotation: NDArray[np.float64] = data.xmat[self._body].reshape(3, 3)
        directions = self._directions_L[first:last] @ rotation.T
        self._directions_W[first:last] = directions
        with self._sight.limited(data.xpos[self._body], directions[0], directions[-1], self._config.range_max_m):
            mujoco.mj_multiRay(
                self._simulation.model, data, data.xpos[self._body], directions.ravel(), self._groups, True, -1,
                self._geoms[first:last], self._distances[first:last], self._normals[first:last].reshape(-1),
                last - first, self._config.range_max_m,
            )  # fmt: skip

    def _scan(self) -> LaserScan:
        c, d = self._config, self._distances
        noisy = d + c.noise_m * self._rng.standard_normal(d.size)
        hit = (self._geoms >= 0) & (d > 0) & (noisy >= c.range_min_m) & (noisy <= c.range_max_m)
        ranges = np.where(hit, noisy, np.inf).astype(np.float32)
        incidence = np.abs(np.einsum("ij,ij->i", self._directions_W, self._normals))
        intensities = np.where(hit, 1000.0 * incidence / np.maximum(d, 1.0), 0.0).astype(np.float32)
        return LaserScan(
            stamp=self._stamp,
            frame=c.link,
            ranges=ranges,
            intensities=intensities,
            angle_min=self._angle_min,
            angle_increment=self._increment,
            range_min=c.range_min_m,
            range_max=c.range_max_m,
            duration_s=c.sweep_s,
            X_BL=self._X_BL,
        )


class _RayTargets:
    """Excludes shapes outside a fan of rays, since ray casting tests every shape for every ray.

    Only static shapes are excluded.
    """

    def __init__(self, simulation: RobotSimulation) -> None:
        model, data = simulation.model, simulation.data
        self._groups = model.geom_group
        standing = (model.geom_group == WORLD_GROUP) & (model.geom_bodyid == 0) & (model.geom_rbound > 0)
        self._geoms = np.flatnonzero(standing)
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
        center, half = model.geom_aabb[self._geoms, :3], model.geom_aabb[self._geoms, 3:]
        rotation = data.geom_xmat[self._geoms].reshape(-1, 3, 3)
        boxes = center[:, None] + half[:, None] * corners
        places = np.einsum("gij,gcj->gci", rotation, boxes)[..., :2]
        self._middles = data.geom_xpos[self._geoms, :2]
        self._radii = np.hypot(places[..., 0], places[..., 1]).max(axis=1)

    @contextlib.contextmanager
    def limited(
        self, origin: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64], range_m: float
    ) -> Iterator[None]:
        """Exclude static shapes outside the fan from ``origin`` that turns left from ``first`` to ``last``."""
        left, right = math.atan2(last[1], last[0]), math.atan2(first[1], first[0])
        half = 0.5 * (left - right) % math.pi + _MARGIN_RAD
        middle = right + half - _MARGIN_RAD
        if half >= 0.5 * math.pi:
            yield
            return
        x, y = self._middles[:, 0] - origin[0], self._middles[:, 1] - origin[1]
        c, s = math.cos(middle), math.sin(middle)
        ahead, aside = c * x + s * y, c * y - s * x
        # Outside: bounding discs beyond the nearer edge of the fan, or too far ahead
        outside = math.cos(half) * np.abs(aside) - math.sin(half) * ahead > self._radii
        outside |= ahead > range_m + self._radii
        hidden = self._geoms[outside]
        self._groups[hidden] = OUT_OF_REACH_GROUP
        try:
            yield
        finally:
            self._groups[hidden] = WORLD_GROUP


def _leave_out_of_reach(simulation: RobotSimulation, height_m: float) -> None:
    """Move static shapes that the laser's plane cannot meet to another group, since casting tests every shape."""
    model, data = simulation.model, simulation.data
    for geom in range(model.ngeom):
        if model.geom_group[geom] != WORLD_GROUP or model.geom_rbound[geom] == 0:
            continue
        center, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        up = data.geom_xmat[geom].reshape(3, 3)[2]
        middle = float(data.geom_xpos[geom][2] + up @ center)
        if abs(middle - height_m) > REACH_M + float(np.abs(up) @ half):
            model.geom_group[geom] = OUT_OF_REACH_GROUP
