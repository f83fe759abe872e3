"""A world of upright boxes on a floor, as a laser and a depth camera see it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image, LaserScan

#: x0, y0, x1, y1, z0, z1 (m)
Box = tuple[float, float, float, float, float, float]

#: Every fourth row and column of a Kinect's.
CAMERA = CameraModel.from_vertical_fov(160, 120, math.radians(43))
_FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def looking(down_deg: float = 0.0, height_m: float = 1.4) -> Pose3:
    """A camera's optical frame in ``base_link``: forward, and down."""
    down = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, math.radians(down_deg), 0.0))
    return Pose3(down.rotation @ _FORWARD, np.array([0.05, 0.0, height_m]))


@dataclass(frozen=True)
class World:
    """Boxes at known places; the floor reaches everywhere but where ``holes`` are."""

    boxes: tuple[Box, ...]
    seed: int = 0
    hole: tuple[float, float, float, float] | None = None

    def hit(self, eye: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far each of ``rays`` (..., 3) goes from ``eye`` (..., 3), in lengths of its own."""
        far = np.full(rays.shape[:-1], np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for x0, y0, x1, y1, z0, z1 in self.boxes:
                a = (np.array([x0, y0, z0]) - eye) / rays
                b = (np.array([x1, y1, z1]) - eye) / rays
                enter, leave = np.fmin(a, b).max(axis=-1), np.fmax(a, b).min(axis=-1)
                far = np.where((enter <= leave) & (enter > 0), np.minimum(far, enter), far)
            for level in (0.0, -1.0):
                floor = np.where(rays[..., 2] < 0, (level - eye[..., 2]) / rays[..., 2], np.inf)
                if level == 0.0 and self.hole is not None:
                    x, y = eye[..., 0] + floor * rays[..., 0], eye[..., 1] + floor * rays[..., 1]
                    inside = (x > self.hole[0]) & (x < self.hole[2]) & (y > self.hole[1]) & (y < self.hole[3])
                    floor = np.where(inside, np.inf, floor)
                far = np.minimum(far, floor)
        return far

    def scan(
        self,
        stamp: float,
        X_WB: Pose2,
        X_WB_end: Pose2 | None = None,
        *,
        noise_m: float = 0.005,
        height_m: float = 0.4,
        fov: float = math.pi,
        rays: int = 720,
    ) -> LaserScan:
        """What a laser 0.2 m ahead of the middle measures; with ``X_WB_end``, ray by ray between the two poses."""
        end, sensor = X_WB_end or X_WB, Pose2(0.2, 0.0, 0.0)
        shares = np.linspace(0.0, 1.0, rays)
        poses = [X_WB.interpolate(end, share) @ sensor for share in (shares if X_WB_end is not None else (0.0,))]
        angles = np.array([pose.theta for pose in poses]) - 0.5 * fov + shares * fov
        directions = np.stack((np.cos(angles), np.sin(angles), np.zeros(rays)), axis=-1)
        ranges = self.hit(np.array([[pose.x, pose.y, height_m] for pose in poses]), directions)
        rng = np.random.default_rng((self.seed, int(1e6 * stamp)))
        noisy = np.where(ranges < 30.0, ranges + noise_m * rng.standard_normal(rays), np.inf).astype(np.float32)
        return LaserScan(
            stamp,
            "laser",
            noisy,
            np.zeros_like(noisy),
            -0.5 * fov,
            fov / (rays - 1),
            0.1,
            30.0,
            0.0125,
            Pose3.from_translation_rpy((0.2, 0.0, height_m)),
        )

    def depth(self, stamp: float, X_WB: Pose2, X_BC: Pose3, *, reach_m: float = 5.0) -> Image:
        """What a depth camera measures: noise as a Kinect's, nothing beyond ``reach_m`` and nearer than 0.4 m."""
        z = _depth(self, X_WB, tuple(X_BC.rotation.ravel()), tuple(X_BC.translation))
        rng = np.random.default_rng((self.seed, int(1e6 * stamp)))
        z = z + (0.0012 + 0.0019 * (np.minimum(z, 9.0) - 0.4) ** 2) * rng.standard_normal(z.shape)
        seen = (z > 0.4) & (z < reach_m)
        depth = np.where(seen, np.rint(1000.0 * np.where(seen, z, 0.0)), 0).astype(np.uint16)
        return Image(stamp, "kinect", np.zeros((1, 1, 3), np.uint8), depth, CAMERA, X_BC)


@lru_cache(8)
def _depth(
    world: World, X_WB: Pose2, rotation: tuple[float, ...], translation: tuple[float, ...]
) -> NDArray[np.float64]:
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    optical = np.stack(((u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)), axis=-1)
    X_WC = X_WB.to_pose3() @ Pose3(np.array(rotation).reshape(3, 3), np.array(translation))
    return world.hit(X_WC.translation, optical @ X_WC.rotation.T)
