"""The point on the floor where the robot will be in a while, by its path or by its twist. Pure."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2


def ahead_on_path(path: NDArray[np.float64], X_FB: Pose2, distance_m: float) -> NDArray[np.float64] | None:
    """Where ``path`` (N, 2) m in frame F is ``distance_m`` beyond the point of it that is nearest to the robot at
    ``X_FB``: (2,) m in ``base_link``; its end, where it is shorter. None without a path."""
    if len(path) == 0:
        return None
    if len(path) == 1:
        return _in_base(path[0], X_FB)
    here = np.array([X_FB.x, X_FB.y])
    begins, steps = path[:-1], np.diff(path, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    along = np.einsum("ij,ij->i", here - begins, steps) / np.maximum(lengths**2, 1e-12)
    shares = np.clip(along, 0.0, 1.0)
    apart = np.hypot(*(begins + shares[:, None] * steps - here).T)
    nearest = int(np.argmin(apart))
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    wanted = ends[nearest] + shares[nearest] * lengths[nearest] + distance_m
    point = np.array([np.interp(wanted, ends, path[:, 0]), np.interp(wanted, ends, path[:, 1])])
    return _in_base(point, X_FB)


def ahead_on_arc(linear_mps: float, angular_radps: float, ahead_s: float, least_m: float) -> NDArray[np.float64]:
    """Where ``base_link`` is after ``ahead_s`` of this twist, but at least ``least_m`` along its arc: (2,) m in today's
    ``base_link``. A robot that turns on the spot looks that far into the direction that it turns to."""
    turned = angular_radps * ahead_s
    distance = linear_mps * ahead_s
    if abs(distance) < least_m:
        distance = math.copysign(least_m, linear_mps)
    if abs(linear_mps) * ahead_s < 1e-3 or abs(turned) < 1e-6:
        return distance * np.array([math.cos(turned), math.sin(turned)])
    # An arc of this length and of the twist's radius, but for no more than the turn that the time allows.
    turned = math.copysign(min(abs(turned), abs(angular_radps / linear_mps * distance)), turned)
    chord = distance * (math.sin(turned / 2) / (turned / 2))
    return chord * np.array([math.cos(turned / 2), math.sin(turned / 2)])


def _in_base(point: NDArray[np.float64], X_FB: Pose2) -> NDArray[np.float64]:
    return np.asarray(X_FB.inverse().transform(point[None, :])[0])
