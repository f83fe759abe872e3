"""Interface of path-tracking controllers: body, state of motion, distance field, path, chosen velocities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.link import BaseLimits

#: Greatest spacing of neighbouring outline points, which ``rollout_kernels`` rely on (m).
_SPACING_M = 0.02
#: Scale of a second outline within the first: an obstacle thin enough to pass between two steps of a rollout meets it.
_INNER = 0.85

Limits = tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class BodyModel:
    """Footprint and limits of the body, as controllers use them.

    ``outline`` (P, 2) float64, m in ``base_link``: points of the footprint's edge, then as many of a smaller copy
    within it. ``radii``: of the largest circle about ``base_link`` inside the footprint, and of the smallest around it.
    ``limits``: least and greatest linear velocity (m/s), greatest angular velocity (rad/s), linear and angular
    acceleration (m/s^2, rad/s^2), linear braking (m/s^2), greatest lateral velocity (m/s; 0: none). ``front_m``:
    greatest x of the edge.
    """

    outline: NDArray[np.float64]
    radii: tuple[float, float]
    limits: Limits
    front_m: float

    @classmethod
    def of(
        cls, footprint: Sequence[tuple[float, float]], limits: BaseLimits, *, padding_m: float = 0.0, back: float = 0.0
    ) -> BodyModel:
        """The body of this ``footprint`` (corners, convex, counter-clockwise, around the origin), widened by
        ``padding_m`` on all sides; ``back``: greatest backward speed as a share of the greatest forward speed.

        Raises ValueError for a footprint of under three corners, or one that does not contain the origin.
        """
        corners = np.asarray(footprint, dtype=np.float64).reshape(-1, 2)
        if len(corners) < 3:
            raise ValueError("a body that drives needs a footprint of at least three corners")
        sides = np.roll(corners, -1, axis=0) - corners
        normals = np.stack((sides[:, 1], -sides[:, 0]), axis=1) / np.linalg.norm(sides, axis=1, keepdims=True)
        reach = np.einsum("ij,ij->i", normals, corners)
        if reach.min() <= 0:
            raise ValueError("a footprint goes counter-clockwise around base_link")
        reach = reach + padding_m
        # Each corner is the intersection of its two sides, moved outwards.
        before = np.roll(np.arange(len(corners)), 1)
        corners = np.stack(
            [np.linalg.solve(normals[[i, j]], reach[[i, j]]) for i, j in zip(range(len(corners)), before, strict=True)]
        )
        edge = _edge(corners, _SPACING_M)
        outline = np.concatenate((edge, _INNER * edge))
        return cls(
            outline=np.ascontiguousarray(outline),
            radii=(float(reach.min()), float(np.linalg.norm(corners, axis=1).max())),
            limits=(
                -back * limits.linear_mps,
                limits.linear_mps,
                limits.angular_radps,
                limits.linear_mps2,
                limits.angular_radps2,
                limits.linear_mps2,
                limits.lateral_mps,
            ),
            front_m=float(corners[:, 0].max()),
        )

    def limited(self, share: float) -> BodyModel:
        """The same body with its speeds scaled by ``share`` (in ]0, 1])."""
        low, high, turn, linear_mps2, angular_radps2, braking, lateral = self.limits
        speeds = (low * share, high * share, turn * share)
        return replace(self, limits=(*speeds, linear_mps2, angular_radps2, braking, lateral * share))

    @property
    def holonomic(self) -> bool:
        """Whether the body can move sideways."""
        return self.limits[6] > 0.0


@dataclass(frozen=True, slots=True)
class MotionState:
    """Pose of the body (in the costmap's frame) and its velocities (m/s, rad/s)."""

    pose: Pose2
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0

    @property
    def speed_mps(self) -> float:
        """Speed in whatever direction (m/s)."""
        return math.hypot(self.linear_mps, self.lateral_mps)

    @property
    def state(self) -> tuple[float, float, float, float, float, float]:
        return (self.pose.x, self.pose.y, self.pose.theta, self.linear_mps, self.angular_radps, self.lateral_mps)

    def after(self, time_s: float) -> MotionState:
        """The state ``time_s`` later at constant velocities."""
        middle = self.pose.theta + 0.5 * self.angular_radps * time_s
        step, aside = self.linear_mps * time_s, self.lateral_mps * time_s
        pose = Pose2(
            self.pose.x + step * math.cos(middle) - aside * math.sin(middle),
            self.pose.y + step * math.sin(middle) + aside * math.cos(middle),
            self.pose.theta + self.angular_radps * time_s,
        )
        return replace(self, pose=pose)


@dataclass(frozen=True, slots=True, eq=False)
class DistanceField:
    """Distances (H, W) float32 (m) from the cells' middles to the nearest obstacle; ``origin`` (m): the lower left
    corner of cell [0, 0]. ``hidden`` (H, W) float32: distances (m) to edges of unseen space (``blind_corners``), None
    to ignore them."""

    distances: NDArray[np.float32]
    origin: tuple[float, float]
    resolution_m: float
    hidden: NDArray[np.float32] | None = None

    @property
    def frame(self) -> tuple[float, float, float]:
        return (self.origin[0], self.origin[1], 1.0 / self.resolution_m)


@dataclass(frozen=True, slots=True, eq=False)
class LocalPath:
    """The path from beside the body on: ``points`` (N, 5) float64, ``spacing`` m apart: x, y, heading (rad), arc length
    (m), greatest speed (m/s). At least two points."""

    points: NDArray[np.float64]
    spacing: float


@dataclass(frozen=True, slots=True, eq=False)
class VelocityChoice:
    """Velocities chosen by a controller. ``blocked``: no admissible motion was found."""

    linear_mps: float
    angular_radps: float
    blocked: bool
    lateral_mps: float = 0.0


class Controller(Protocol):
    """Tracks a path without contact. One object drives one body; deterministic in its inputs."""

    def choose(
        self, motion: MotionState, field: DistanceField, way: LocalPath, body: BodyModel, period_s: float
    ) -> VelocityChoice:
        """The velocities to command for the next ``period_s`` seconds; within the body's limits and accelerations."""

    def reset(self) -> None:
        """Discard all state: the goal, the path or the body's place changed."""


def _edge(corners: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    points = []
    for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        count = max(1, math.ceil(float(np.linalg.norm(end - begin)) / spacing_m))
        points.append(begin + (end - begin) * (np.arange(count) / count)[:, None])
    return np.concatenate(points)
