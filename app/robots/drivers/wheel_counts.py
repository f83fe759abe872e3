"""Odometry of two wheels by their counts: exact arcs, over counters that run over and begin again."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2, wrap_angle

_MODULUS = 2**32
#: Beyond what the base can have driven, so much more (m) is a counter that began again.
JUMP_M = 0.25


@dataclass(frozen=True, slots=True)
class WheelGeometry:
    """Counts of a metre of a wheel's way, the distance (m) between the wheels, and the base's greatest speed (m/s)."""

    ticks_per_m: float
    track_m: float
    most_mps: float


@dataclass(frozen=True, slots=True)
class WheelPath:
    """Where the base is by its wheels: ``pose`` (``X_OB``), its velocity (m/s, rad/s), the ways of both wheels (m), and
    the newest counts (``left``, ``right``) at ``stamp`` (s), None before the first."""

    pose: Pose2
    linear_mps: float = 0.0
    angular_radps: float = 0.0
    left_m: float = 0.0
    right_m: float = 0.0
    left: int | None = None
    right: int | None = None
    stamp: float = 0.0


def restarted(path: WheelPath, left: int, right: int, stamp: float) -> WheelPath:
    """``path`` with counters that began again: the base stays where it was."""
    return WheelPath(path.pose, left_m=path.left_m, right_m=path.right_m, left=left, right=right, stamp=stamp)


def followed(path: WheelPath, geometry: WheelGeometry, *, left: int, right: int, stamp: float) -> WheelPath | None:
    """``path`` after the counts ``left`` and ``right`` (signed, 32 bits) at ``stamp``; None where the base cannot have
    driven so far: its counters began again."""
    if path.left is None or path.right is None:
        return restarted(path, left, right, stamp)
    seconds = stamp - path.stamp
    ways = [_difference(now, before) / geometry.ticks_per_m for now, before in ((left, path.left), (right, path.right))]
    if max(map(abs, ways)) > JUMP_M + 2.0 * geometry.most_mps * max(seconds, 0.0):
        return None
    way, turn = (ways[0] + ways[1]) / 2, (ways[1] - ways[0]) / geometry.track_m
    chord = way * (math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1.0)
    along = path.pose.theta + turn / 2
    pose = Pose2(
        path.pose.x + chord * math.cos(along), path.pose.y + chord * math.sin(along), wrap_angle(path.pose.theta + turn)
    )
    moving = seconds > 0
    return WheelPath(
        pose,
        linear_mps=way / seconds if moving else path.linear_mps,
        angular_radps=turn / seconds if moving else path.angular_radps,
        left_m=path.left_m + ways[0],
        right_m=path.right_m + ways[1],
        left=left,
        right=right,
        stamp=stamp,
    )


def _difference(now: int, before: int) -> int:
    return (now - before + _MODULUS // 2) % _MODULUS - _MODULUS // 2
