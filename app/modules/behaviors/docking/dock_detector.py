"""A dock in one laser scan: two plates that meet in a V, open towards the robot.

Near the expected place, poses whose outline lies on many points are candidates; the best is refined by least squares of
the points' distances to the two lines (Gauss-Newton), each point assigned to one of them. A V counts only if points
cover both plates and none go on beyond the tips, as those of a room's corner do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.messages import LaserScan

Floats = NDArray[np.float64]

_ITERATIONS = 8
_HEADING_STEP = math.radians(6)
#: Greatest number of points that are tried as where the plates meet, and that count for each.
_MOST_POINTS = 120


@dataclass(frozen=True, slots=True)
class DockShape:
    """``plate_m``: length of each plate; ``opening_rad``: the angle between them."""

    plate_m: float = 0.25
    opening_rad: float = 2 * math.pi / 3


@dataclass(frozen=True, slots=True)
class DetectorRules:
    """``reach_m``, ``turn_rad``: how far from the expected pose a dock is looked for. ``near_m``: greatest distance of
    a point of a plate from its line. ``rms_m``: greatest mean of these distances. ``cover``: least share of each plate
    that has points. ``slope``: greatest slope of its points against its line. ``bins``: into how many pieces a plate is
    parted for the cover."""

    reach_m: float = 0.5
    turn_rad: float = math.radians(35)
    near_m: float = 0.035
    rms_m: float = 0.018
    cover: float = 0.7
    slope: float = 0.11
    bins: int = 8


def scan_points(scan: LaserScan) -> Floats:
    """Points (N, 2) m of ``scan`` in ``base_link`` at the middle of its sweep."""
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    measured = np.isfinite(scan.ranges) & (scan.ranges >= scan.range_min) & (scan.ranges < scan.range_max)
    ranges = scan.ranges[measured].astype(np.float64)
    in_laser = np.stack([ranges * np.cos(angles[measured]), ranges * np.sin(angles[measured])], axis=1)
    return np.asarray(in_laser @ scan.X_BL.rotation[:2, :2].T + scan.X_BL.translation[:2])


def find_dock(
    points: Floats,
    expected: Pose2,
    shape: DockShape,
    rules: DetectorRules,
    *,
    search: bool = True,
) -> Pose2 | None:
    """``X_BD`` of the dock among ``points`` (N, 2) m near the ``expected`` pose; None if there is none.

    The dock's origin is where its plates meet, its x axis points out of the V. With ``search`` many poses within the
    rules' reach are tried, else only the expected one is refined.
    """
    offsets = points - np.array([expected.x, expected.y])
    near = points[np.hypot(offsets[:, 0], offsets[:, 1]) <= rules.reach_m + shape.plate_m]
    if len(near) < 2 * rules.bins:
        return None
    begin = _best_candidate(near, expected, shape, rules) if search else expected
    found = _refined(near, begin, shape, rules)
    if found is None or not _is_near(found, expected, rules) or not _is_dock(near, found, shape, rules):
        return None
    return found


def _best_candidate(points: Floats, expected: Pose2, shape: DockShape, rules: DetectorRules) -> Pose2:
    """The pose, of those with their origin on a point, whose outline lies on the most points."""
    points = points[:: max(1, math.ceil(len(points) / _MOST_POINTS))]
    offsets = points - np.array([expected.x, expected.y])
    origins = points[np.hypot(offsets[:, 0], offsets[:, 1]) <= rules.reach_m]
    best, score = expected, -1
    steps = int(rules.turn_rad / _HEADING_STEP)
    for number in range(-steps, steps + 1):
        heading = wrap_angle(expected.theta + number * _HEADING_STEP)
        along, beside = _by_plate(points[None] - origins[:, None], heading, shape)
        hits = (np.abs(beside) < rules.near_m) & (along >= 0) & (along <= shape.plate_m)
        scores = hits.sum(axis=1)
        if len(scores) and scores.max() > score:
            place = int(scores.argmax())
            best, score = Pose2(float(origins[place, 0]), float(origins[place, 1]), heading), int(scores[place])
    return best


def _by_plate(relative: Floats, heading: float, shape: DockShape) -> tuple[Floats, Floats]:
    """Of points (..., 2) relative to the origin: how far along the nearer plate, and how far beside it (m)."""
    c, s = math.cos(heading), math.sin(heading)
    x = c * relative[..., 0] + s * relative[..., 1]
    y = -s * relative[..., 0] + c * relative[..., 1]
    half = shape.opening_rad / 2
    along = math.cos(half) * x + math.sin(half) * np.abs(y)
    beside = -math.sin(half) * x + math.cos(half) * np.abs(y)
    return along, beside


def _refined(points: Floats, begin: Pose2, shape: DockShape, rules: DetectorRules) -> Pose2 | None:
    pose, half = begin, shape.opening_rad / 2
    normals = np.array([[-math.sin(half), math.cos(half)], [-math.sin(half), -math.cos(half)]])
    for iteration in range(_ITERATIONS):
        local = pose.inverse().transform(points)
        along, beside = _by_plate(local, 0.0, shape)
        near_m = rules.near_m if iteration > 2 else 2 * rules.near_m
        used = (np.abs(beside) < near_m) & (along > -0.02) & (along < shape.plate_m + 0.02)
        left = local[:, 1] >= 0
        if min(np.count_nonzero(used & left), np.count_nonzero(used & ~left)) < 3:
            return None
        x, y = local[used, 0], local[used, 1]
        normal = np.where(left[used, None], normals[0], normals[1])
        # A step (dx, dy, turn) of the pose moves a point of the dock's frame by the opposite.
        jacobian = np.stack([-normal[:, 0], -normal[:, 1], normal[:, 0] * y - normal[:, 1] * x], axis=1)
        step, *_ = np.linalg.lstsq(jacobian, -beside[used], rcond=None)
        pose = pose @ Pose2(*(float(value) for value in step))
        if float(np.abs(step).max()) < 1e-5:
            break
    return pose


def _is_near(found: Pose2, expected: Pose2, rules: DetectorRules) -> bool:
    apart = math.hypot(found.x - expected.x, found.y - expected.y)
    return apart <= rules.reach_m and abs(wrap_angle(found.theta - expected.theta)) <= rules.turn_rad


def _is_dock(points: Floats, pose: Pose2, shape: DockShape, rules: DetectorRules) -> bool:
    local = pose.inverse().transform(points)
    along, beside = _by_plate(local, 0.0, shape)
    on_line = np.abs(beside) < rules.near_m
    on_plate = on_line & (along >= 0) & (along <= shape.plate_m)
    if not on_plate.any() or math.sqrt(float(np.mean(beside[on_plate] ** 2))) > rules.rms_m:
        return False
    beyond = on_line & (along > shape.plate_m + 0.03) & (along < shape.plate_m + 0.15)
    for side in (local[:, 1] >= 0, local[:, 1] < 0):
        here = on_plate & side
        pieces = np.unique((along[here] / shape.plate_m * rules.bins).astype(int).clip(0, rules.bins - 1))
        if len(pieces) < rules.cover * rules.bins:
            return False
        if np.count_nonzero(beyond & side) > 0.3 * np.count_nonzero(here):
            return False
        # Lines that meet at another angle, as those of a square corner, show in the slope of what is left.
        slope, _ = np.polyfit(along[here], beside[here], 1)
        if abs(float(slope)) > rules.slope:
            return False
    return True
