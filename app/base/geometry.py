"""Poses, transforms, angles and camera models: pure functions and frozen values, nothing else.

Frames are right-handed, x forward, y left, z up (REP 103). Camera *optical* frames are x right, y down, z forward.
Monograms: ``X_WB`` is the pose of B in W and maps coordinates of B into coordinates of W; ``X_WB @ X_BC == X_WC``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.floating[Any]]


def wrap_angle(angle: float) -> float:
    """Return ``angle`` (rad) wrapped into ``[-pi, pi)``."""
    wrapped = (angle + math.pi) % (2.0 * math.pi) - math.pi
    # Just below -pi, rounding makes the remainder the modulus itself.
    return wrapped if wrapped < math.pi else -math.pi


def unit_vector(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """The direction (3,) of two angles (rad): azimuth about z from x, left positive, and elevation, up positive."""
    ahead = math.cos(elevation)
    return np.array([ahead * math.cos(azimuth), ahead * math.sin(azimuth), math.sin(elevation)])


def azimuth_elevation(v: FloatArray) -> tuple[float, float]:
    """Azimuth and elevation (rad; left and up positive) of a vector (3,)."""
    x, y, z = (float(value) for value in v)
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))


@dataclass(frozen=True, slots=True)
class Pose2:
    """A planar pose: ``x``, ``y`` in metres, ``theta`` in radians (not necessarily wrapped)."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __matmul__(self, other: Pose2) -> Pose2:
        """Compose: ``X_AC = X_AB @ X_BC``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> Pose2:
        """Return ``X_BA`` of this ``X_AB``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.theta))

    def interpolate(self, other: Pose2, fraction: float) -> Pose2:
        """Pose between this (0) and ``other`` (1): linear in position, along the shorter arc in angle."""
        turn = wrap_angle(other.theta - self.theta)
        return Pose2(
            self.x + fraction * (other.x - self.x),
            self.y + fraction * (other.y - self.y),
            wrap_angle(self.theta + fraction * turn),
        )

    def transform(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map ``points`` (..., 2) from B to A for this ``X_AB``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return np.asarray(points @ np.array([[c, s], [-s, c]]) + np.array([self.x, self.y]))

    def to_pose3(self) -> Pose3:
        """The same pose in space, in the plane z = 0."""
        return Pose3.from_translation_rpy((self.x, self.y, 0.0), (0.0, 0.0, self.theta))


@dataclass(frozen=True, slots=True, eq=False)
class Pose3:
    """A pose in space: ``rotation`` (3, 3) orthonormal, ``translation`` (3,) in metres; both float64."""

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    @staticmethod
    def identity() -> Pose3:
        """The pose of a frame in itself."""
        return Pose3(np.eye(3), np.zeros(3))

    @staticmethod
    def from_translation_rpy(
        translation: tuple[float, float, float], rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> Pose3:
        """Pose from a translation (m) and fixed-axis roll, pitch, yaw (rad), as in URDF's ``origin``."""
        roll, pitch, yaw = rpy
        cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
        rotation = np.array(
            [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ]
        )
        return Pose3(rotation, np.array(translation, dtype=np.float64))

    def __matmul__(self, other: Pose3) -> Pose3:
        """Compose: ``X_AC = X_AB @ X_BC``."""
        return Pose3(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

    def inverse(self) -> Pose3:
        """Return ``X_BA`` of this ``X_AB``."""
        return Pose3(self.rotation.T, -self.rotation.T @ self.translation)

    def transform(self, points: FloatArray) -> FloatArray:
        """Map ``points`` (..., 3) from B to A for this ``X_AB``; keeps a float32 input float32."""
        rotation = self.rotation.astype(points.dtype, copy=False)
        return points @ rotation.T + self.translation.astype(points.dtype, copy=False)

    def quaternion_wxyz(self) -> tuple[float, float, float, float]:
        """The rotation as a unit quaternion (w, x, y, z), w >= 0 (Shepperd's method, branch on the largest term)."""
        m = self.rotation
        trace = float(m[0, 0] + m[1, 1] + m[2, 2])
        squares = (trace, float(m[0, 0]), float(m[1, 1]), float(m[2, 2]))
        largest = max(range(4), key=squares.__getitem__)
        if largest == 0:
            q = np.array([1 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
        else:
            i = largest - 1
            j, k = (i + 1) % 3, (i + 2) % 3
            q = np.zeros(4)
            q[0] = m[k, j] - m[j, k]
            q[1 + i] = 1 + m[i, i] - m[j, j] - m[k, k]
            q[1 + j] = m[j, i] + m[i, j]
            q[1 + k] = m[k, i] + m[i, k]
        q = q / np.linalg.norm(q)
        if q[0] < 0:
            q = -q
        return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A pinhole camera without distortion: image size (px), focal lengths and principal point (px).

    Pixel (u, v) is column, row; (0, 0) is the centre of the upper-left pixel. Points are in the optical frame.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @staticmethod
    def from_vertical_fov(width: int, height: int, fovy: float) -> CameraModel:
        """Square pixels and a centred principal point; ``fovy`` is the full vertical field of view (rad)."""
        f = 0.5 * height / math.tan(0.5 * fovy)
        return CameraModel(width, height, fx=f, fy=f, cx=0.5 * (width - 1), cy=0.5 * (height - 1))

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels (..., 2) of ``points`` (..., 3) in the optical frame; NaN where a point is not in front."""
        z = np.where(points[..., 2] > 0, points[..., 2], np.nan)
        u = self.fx * points[..., 0] / z + self.cx
        v = self.fy * points[..., 1] / z + self.cy
        return np.stack((u, v), axis=-1)

    def back_project(self, pixels: FloatArray, depth: FloatArray) -> FloatArray:
        """Points (..., 3) in the optical frame of ``pixels`` (..., 2) at ``depth`` (...), m along the optical axis."""
        x = (pixels[..., 0] - self.cx) / self.fx * depth
        y = (pixels[..., 1] - self.cy) / self.fy * depth
        return np.stack((x, y, depth), axis=-1)

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Unit vectors (..., 3) in the optical frame along which ``pixels`` (..., 2) look."""
        x = (pixels[..., 0] - self.cx) / self.fx
        y = (pixels[..., 1] - self.cy) / self.fy
        rays = np.stack((x, y, np.ones_like(x)), axis=-1)
        return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))


@dataclass(frozen=True, slots=True)
class FisheyeModel:
    """An equidistant fisheye camera: the angle θ off the optical axis grows evenly from the image's middle outwards.

    u = cx + fx θ cos φ and v = cy + fy θ sin φ, φ being the direction around the axis, from x (right) towards y (down);
    ``fx`` and ``fy`` (px per rad) differ where the lens stretches the circle to fill the sensor. It is OpenCV's and
    ROS's ``equidistant`` model (Kannala and Brandt, 2006) without higher terms. Nothing is seen beyond ``theta_max``
    (rad). Pixels as in :class:`CameraModel`.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    theta_max: float = math.pi / 2

    @staticmethod
    def from_fov(width: int, height: int, horizontal: float, vertical: float) -> FisheyeModel:
        """A lens whose fields of view (full angles, rad) fill the image's width and height; the wider is its limit."""
        return FisheyeModel(
            width,
            height,
            fx=width / horizontal,
            fy=height / vertical,
            cx=0.5 * (width - 1),
            cy=0.5 * (height - 1),
            theta_max=0.5 * max(horizontal, vertical),
        )

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels (..., 2) of ``points`` (..., 3) in the optical frame; NaN beyond ``theta_max``, and at the origin."""
        across = np.hypot(points[..., 0], points[..., 1])
        theta = np.arctan2(across, points[..., 2])
        seen = (theta <= self.theta_max) & ((across > 0) | (points[..., 2] > 0))
        # Towards the axis θ / sin θ goes to 1.
        stretch = np.where(across > 0, theta / np.where(across > 0, across, 1.0), 0.0)
        stretch = np.where(seen, stretch, np.nan)
        return np.stack(
            (self.fx * stretch * points[..., 0] + self.cx, self.fy * stretch * points[..., 1] + self.cy), axis=-1
        )

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Unit vectors (..., 3) in the optical frame along which ``pixels`` (..., 2) look; NaN beyond ``theta_max``."""
        x = (pixels[..., 0] - self.cx) / self.fx
        y = (pixels[..., 1] - self.cy) / self.fy
        theta = np.hypot(x, y)
        theta = np.where(theta <= self.theta_max, theta, np.nan)
        shrink = np.sinc(theta / np.pi)
        return np.stack((shrink * x, shrink * y, np.cos(theta)), axis=-1)

    def back_project(self, pixels: FloatArray, distance: FloatArray) -> FloatArray:
        """Points (..., 3) in the optical frame of ``pixels`` (..., 2) at ``distance`` (...), m along the ray."""
        return np.asarray(self.rays(pixels) * np.asarray(distance)[..., None])
