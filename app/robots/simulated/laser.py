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
from app.robots.simulated.body import PREFIX, RobotSimulation
from app.robots.simulated.scenery.people import LASER_GROUP
from app.robots.simulated.world import WORLD_GROUP
from app.robots.stream_config import HokuyoConfig

FAN_S = 0.0035
"""Longest duration of one fan of rays: at 1 rad/s the base turns less than one ray's step in it."""
_MARGIN_RAD = math.radians(1.0)
"""Pitch and roll of the base, which tilt the fan."""
_CAST_GROUP, _EXCLUDED_GROUP = 0, 2
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
        self._groups = np.array([group == _CAST_GROUP for group in range(6)], dtype=np.uint8)
        self._sight = _RayTargets(simulation, float(X_BL.translation[2]))
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
        self._sight.follow()
        with self._sight.limited(data.xpos[self._body], directions[0], directions[-1], self._config.range_max_m):
            mujoco.mj_multiRay(
                self._sight.model, self._sight.data, data.xpos[self._body], directions.ravel(), self._groups, True,
                -1, self._geoms[first:last], self._distances[first:last],
                self._normals[first:last].reshape(-1), last - first, self._config.range_max_m,
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
    """What the laser can meet, in a small model of its own: casting a ray passes every shape of a model, one by one.

    Shapes of the world that stand still are left out where the laser's plane at ``height_m`` does not come, and, for a
    fan of rays, outside of it.
    """

    def __init__(self, simulation: RobotSimulation, height_m: float) -> None:
        model, data = simulation.model, simulation.data
        spec = mujoco.MjSpec()
        carriers: list[int] = []
        shapes = np.flatnonzero(np.isin(model.geom_group, (WORLD_GROUP, LASER_GROUP)))
        for carrier in np.unique(model.geom_bodyid[shapes]):
            own = shapes[model.geom_bodyid[shapes] == carrier]
            if carrier == 0:
                own = own[_in_reach(model, data, own, height_m)]
                body = spec.worldbody
            else:
                carriers.append(int(carrier))
                body = spec.worldbody.add_body(mocap=True)
            for geom in own:
                body.add_geom(
                    type=model.geom_type[geom],
                    size=model.geom_size[geom],
                    pos=model.geom_pos[geom],
                    quat=model.geom_quat[geom],
                )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._source, self._carriers = data, carriers
        self.follow()
        self._groups = self.model.geom_group
        still = (self.model.geom_bodyid == 0) & (self.model.geom_rbound > 0)
        self._geoms = np.flatnonzero(still)
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
        center, half = self.model.geom_aabb[self._geoms, :3], self.model.geom_aabb[self._geoms, 3:]
        rotation = self.data.geom_xmat[self._geoms].reshape(-1, 3, 3)
        boxes = center[:, None] + half[:, None] * corners
        places = np.einsum("gij,gcj->gci", rotation, boxes)[..., :2]
        self._middles = self.data.geom_xpos[self._geoms, :2]
        self._radii = np.hypot(places[..., 0], places[..., 1]).max(axis=1)

    def follow(self) -> None:
        """Put what moves where it is now."""
        self.data.mocap_pos[:] = self._source.xpos[self._carriers]
        self.data.mocap_quat[:] = self._source.xquat[self._carriers]
        mujoco.mj_kinematics(self.model, self.data)

    @contextlib.contextmanager
    def limited(
        self, origin: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64], range_m: float
    ) -> Iterator[None]:
        """Exclude still shapes outside the fan from ``origin`` that turns left from ``first`` to ``last``."""
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
        self._groups[self._geoms[outside]] = _EXCLUDED_GROUP
        try:
            yield
        finally:
            self._groups[self._geoms] = _CAST_GROUP


def _in_reach(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: NDArray[np.intp], height_m: float
) -> NDArray[np.bool_]:
    """Which of the still shapes ``geoms`` (n,) the laser's plane at ``height_m`` can meet."""
    center, half = model.geom_aabb[geoms, :3], model.geom_aabb[geoms, 3:]
    up = data.geom_xmat[geoms].reshape(-1, 3, 3)[:, 2]
    middle = data.geom_xpos[geoms][:, 2] + (up * center).sum(axis=1)
    near = np.abs(middle - height_m) <= REACH_M + (np.abs(up) * half).sum(axis=1)
    return np.asarray(near | (model.geom_rbound[geoms] == 0))
