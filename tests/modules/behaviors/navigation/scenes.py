"""Scenes for controllers: fields of distances around obstacles, ways, and what really happens to a commanded body."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.modules.behaviors.navigation.controller import BodyModel, DistanceField, LocalPath, MotionState, VelocityChoice
from app.modules.behaviors.navigation.planning.reference_path import ReferencePath

LIMITS = BaseLimits(0.40, 1.00, 0.40, 4.00)
SQUARE = ((0.25, -0.25), (0.25, 0.25), (-0.25, 0.25), (-0.25, -0.25))
FAST = BaseLimits(2.0, 4.0, 4.0, 12.0)
HOLONOMIC = BaseLimits(0.40, 1.00, 0.40, 4.00, lateral_mps=0.30)
LONG = ((0.254, -0.215), (0.254, 0.215), (-0.254, 0.215), (-0.254, -0.215))


def field_of(obstacles: NDArray[np.float64], size_m: float = 6.0, resolution_m: float = 0.025) -> DistanceField:
    """The field around (0, 0) of point obstacles (N, 2) m."""
    cells = round(size_m / resolution_m)
    free = np.ones((cells, cells), dtype=np.uint8)
    where = np.floor((obstacles + size_m / 2) / resolution_m).astype(int)
    inside = ((where >= 0) & (where < cells)).all(axis=1)
    free[where[inside, 1], where[inside, 0]] = 0
    distances = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(resolution_m)
    if free.all():
        distances = np.full_like(distances, size_m)
    return DistanceField(np.ascontiguousarray(distances), (-size_m / 2, -size_m / 2), resolution_m)


def wall(x0: float, y0: float, x1: float, y1: float) -> NDArray[np.float64]:
    """Point obstacles (N, 2) along a line, closer than any cell."""
    count = math.ceil(math.hypot(x1 - x0, y1 - y0) / 0.01) + 1
    return np.stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count)), axis=1)


def way_along(points: list[tuple[float, float]], pose: Pose2, limits: BaseLimits, length_m: float = 6.0) -> LocalPath:
    """The way along ``points`` from beside ``pose`` on."""
    track = ReferencePath(np.array(points), speed_mps=limits.linear_mps, braking_mps2=limits.linear_mps2)
    track.come_to(pose)
    return track.ahead(Pose2(), length_m)


def distance_to(obstacles: NDArray[np.float64], pose: Pose2, half_x: float, half_y: float) -> float:
    """Exactly how far (m) a rectangle's edge is from the nearest obstacle; under zero inside of it."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    dx, dy = obstacles[:, 0] - pose.x, obstacles[:, 1] - pose.y
    ahead, aside = np.abs(c * dx + s * dy) - half_x, np.abs(c * dy - s * dx) - half_y
    outside = np.hypot(np.maximum(ahead, 0), np.maximum(aside, 0))
    return float(np.where(outside > 0, outside, np.maximum(ahead, aside)).min())


def driven(
    motion: MotionState, linear: float, angular: float, limits: BaseLimits, time_s: float, *, lateral: float = 0.0
) -> MotionState:
    """What a body with these limits does, in steps of 5 ms."""
    pose, v, w, u = motion.pose, motion.linear_mps, motion.angular_radps, motion.lateral_mps
    for _ in range(max(1, round(time_s / 0.005))):
        v, u = limits.ramped((v, u), (linear, lateral), 0.005)
        w += float(np.clip(angular - w, -limits.angular_radps2 * 0.005, limits.angular_radps2 * 0.005))
        middle = pose.theta + 0.5 * w * 0.005
        c, s = math.cos(middle) * 0.005, math.sin(middle) * 0.005
        pose = Pose2(pose.x + v * c - u * s, pose.y + v * s + u * c, pose.theta + w * 0.005)
    return MotionState(pose, v, w, u)


def body_of(limits: BaseLimits, footprint: tuple[tuple[float, float], ...]) -> BodyModel:
    """A body to be driven."""
    return BodyModel.of(footprint, limits)


def is_still(choice: VelocityChoice) -> bool:
    """Whether it commands to stand."""
    return choice.linear_mps == 0.0 and choice.angular_radps == 0.0
