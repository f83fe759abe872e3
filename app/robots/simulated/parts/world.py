"""The floor that a simulated robot of parts drives on: its wheels move it over a map, its laser looks around there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.maps.grid_rays import GridRays
from app.messages import OccupancyGrid
from app.robots.drivers.base_firmware import BaseFirmware
from app.robots.drivers.config import DriversConfig
from app.robots.guard import BaseVelocity
from app.robots.simulated.kinematic.base import Outline, moved
from app.robots.simulated.kinematic.config import KinematicLaserConfig
from app.robots.simulated.kinematic.laser import KinematicLaser
from app.robots.simulated.parts.hokuyo_laser import FIRST, LAST, LEAST_MM, NOTHING_MM, TURN

CELL_M = 0.05


def room() -> OccupancyGrid:
    """A room of 6 m by 4 m: walls at x = -0.95 and 4.95, y = -1.95 and 1.95 (m), and a pillar of 0.4 m at (3.0, 0)."""
    cells = np.zeros((80, 120), np.int8)
    cells[0], cells[-1], cells[:, 0], cells[:, -1] = 100, 100, 100, 100
    cells[36:44, 76:84] = 100
    return OccupancyGrid(0.0, "map", cells, CELL_M, origin=(-1.0, -2.0), version=1)


class PartsWorld:
    """The robot of ``config`` on ``grid``, at ``pose`` (``X_WB``)."""

    def __init__(self, config: DriversConfig, grid: OccupancyGrid, pose: Pose2) -> None:
        self.pose = pose
        self.velocity = BaseVelocity()
        self._rays = GridRays(grid)
        self._outline = Outline(config.footprint, grid.resolution_m)
        self._laser: KinematicLaser | None = None
        if config.hokuyo is not None:
            fov_deg = 360.0 * (LAST - FIRST) / TURN
            seen = KinematicLaserConfig(
                link=config.hokuyo.link, rays=LAST - FIRST + 1, fov_deg=fov_deg, range_min_m=LEAST_MM / 1000.0,
                range_max_m=30.0, noise_m=0.01,
            )  # fmt: skip
            self._laser = KinematicLaser(seen, load_model(config.model).pose(seen.link), self._rays, seed=1)

    def step(self, firmware: BaseFirmware, seconds: float) -> None:
        """Turn the wheels as ``firmware`` asks, for ``seconds``; before an obstacle they stand."""
        left, right = firmware.wheels_mps
        velocity = BaseVelocity((left + right) / 2, (right - left) / firmware.setting.track_m)
        ahead = moved(self.pose, velocity, seconds)
        if self._outline.meets(ahead, self._rays) and not self._outline.meets(self.pose, self._rays):
            self.velocity = BaseVelocity()
            return
        self.pose, self.velocity = ahead, velocity
        firmware.rolled(left * seconds, right * seconds)

    def distances(self) -> NDArray[np.int64]:
        """What the laser measures now (1081,), mm."""
        assert self._laser is not None
        ranges = self._laser.scan(0.0, self.pose).ranges.astype(np.float64)
        within = np.where(np.isfinite(ranges), 1000.0 * ranges, NOTHING_MM)
        return np.asarray(np.rint(within), np.int64)

    def row(self, monotonic: float) -> str:
        """A line of a log of the truth."""
        at, velocity = self.pose, self.velocity
        linear, angular = velocity.linear_mps, velocity.angular_radps
        return f"{monotonic:.4f} {linear:.5f} {angular:.5f} {at.x:.5f} {at.y:.5f} {math.degrees(at.theta):.3f}\n"
