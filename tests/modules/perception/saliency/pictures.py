"""Synthetic pictures of coloured discs around the camera, of which each direction is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3, unit_vector

KINECT = CameraModel.from_vertical_fov(320, 240, math.radians(43))
FISHEYE = FisheyeModel.from_fov(512, 384, math.pi, math.pi)
#: Optical axes in those of a body that looks ahead.
_AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class Disc:
    """A disc of ``color`` (of 255) in a direction (rad, in odom's axes), ``radius`` rad wide."""

    azimuth: float
    elevation: float
    color: tuple[int, int, int]
    radius: float = math.radians(4)


def camera_at(heading: float = 0.0, p_OC: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Pose3:
    """X_OC of a camera that looks level in a direction."""
    turned = Pose2(0.0, 0.0, heading).to_pose3()
    return Pose3(turned.rotation @ _AHEAD, np.array(p_OC))


def picture(
    camera: CameraModel | FisheyeModel,
    X_OC: Pose3,
    discs: Sequence[Disc],
    *,
    ground: tuple[int, int, int] = (120, 120, 120),
    noise: float = 0.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """What ``camera`` sees at ``X_OC``: discs far off on a ground of one colour, with a sensor's noise."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = camera.rays(np.stack((u, v), axis=-1).astype(np.float64)) @ X_OC.rotation.T
    seen = np.empty((camera.height, camera.width, 3))
    seen[:] = ground
    for disc in discs:
        inside = rays @ unit_vector(disc.azimuth, disc.elevation) > math.cos(disc.radius)
        seen[inside] = disc.color
    seen[np.isnan(rays[..., 0])] = 0
    if noise > 0:
        seen += np.random.default_rng(seed).normal(0.0, noise, seen.shape)
    return np.clip(seen, 0, 255).astype(np.uint8)
