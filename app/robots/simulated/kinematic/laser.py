"""The laser of a kinematic body: rays on the map's grid, and on the legs of people."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.maps.grid_rays import GridRays
from app.messages import LaserScan, read_only
from app.robots.simulated.kinematic.base import Discs
from app.robots.simulated.kinematic.config import KinematicLaserConfig
from app.robots.simulated.scenery import gait
from app.robots.simulated.scenery.actor import Actor

LEG_RADIUS_SHARE = 0.032
"""Of a person's height, as in the simulated lab."""
_INTENSITY = 1000.0


class KinematicLaser:
    """A laser at ``X_BL`` in ``base_link``, with ``seed`` for its noise. All rays of a sweep leave at once."""

    def __init__(self, config: KinematicLaserConfig, X_BL: Pose3, rays: GridRays, seed: int) -> None:
        self._config = config
        self._X_BL = Pose3(read_only(X_BL.rotation), read_only(X_BL.translation))
        x, y, _ = X_BL.translation.tolist()
        self._mount = Pose2(x, y, math.atan2(float(X_BL.rotation[1, 0]), float(X_BL.rotation[0, 0])))
        self._rays = rays
        self._rng = np.random.default_rng([seed, 2])
        fov = math.radians(config.fov_deg)
        self._increment = fov / (config.rays - 1)
        self._angles = np.linspace(-fov / 2, fov / 2, config.rays, dtype=np.float64)

    def scan(self, stamp: float, X_WB: Pose2, discs: Discs = ()) -> LaserScan:
        """The scan at ``stamp`` with the robot at ``X_WB`` and legs on ``discs``."""
        config, X_WL = self._config, X_WB @ self._mount
        ranges = self._rays.cast(X_WL.x, X_WL.y, X_WL.theta + self._angles, config.range_max_m)
        ranges = np.minimum(ranges, met(X_WL, self._angles, discs))
        if config.noise_m:
            ranges = ranges + config.noise_m * self._rng.standard_normal(ranges.size)
        hit = (ranges >= config.range_min_m) & (ranges <= config.range_max_m)
        intensities = np.where(hit, _INTENSITY / np.maximum(np.where(hit, ranges, 1.0), 1.0), 0.0)
        return LaserScan(
            stamp=stamp,
            frame=config.link,
            ranges=read_only(np.where(hit, ranges, np.inf).astype(np.float32)),
            intensities=read_only(intensities.astype(np.float32)),
            angle_min=float(self._angles[0]),
            angle_increment=self._increment,
            range_min=config.range_min_m,
            range_max=config.range_max_m,
            duration_s=0.0,
            X_BL=self._X_BL,
        )


def met(X_WL: Pose2, angles: NDArray[np.float64], discs: Discs) -> NDArray[np.float64]:
    """Distances (N,) from the laser to the nearest of ``discs`` on the floor at each of ``angles`` (N; rad, its own);
    infinite where a ray meets none."""
    if not discs:
        return np.full(angles.size, math.inf)
    middles = X_WL.inverse().transform(np.array([disc[:2] for disc in discs]))
    radii = np.array([disc[2] for disc in discs])[:, None]
    ahead = middles[:, :1] * np.cos(angles) + middles[:, 1:] * np.sin(angles)
    aside = middles[:, 1:] * np.cos(angles) - middles[:, :1] * np.sin(angles)
    half = np.sqrt(np.maximum(radii**2 - aside**2, 0.0))
    hit = (np.abs(aside) < radii) & (ahead > 0.0)
    return np.asarray(np.where(hit, np.maximum(ahead - half, 0.0), np.inf).min(axis=0))


def legs(actors: Iterable[Actor]) -> Discs:
    """The shins of ``actors``, where their knees are."""
    found = []
    for actor in actors:
        joints = gait.joints(actor.posture)
        c, s = math.cos(actor.heading), math.sin(actor.heading)
        for side in ("left", "right"):
            x, y, _ = (actor.height_m * part for part in joints[f"{side}_shin"].at)
            place = actor.x + c * x - s * y, actor.y + s * x + c * y
            found.append((*place, LEG_RADIUS_SHARE * actor.height_m))
    return found
