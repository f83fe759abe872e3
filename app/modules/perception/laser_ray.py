"""Intersection of a camera's ray with a wall in the laser scan: position of an object on the wall (thesis 4.2). Pure
functions.

A camera without depth gives only a code's direction. Walls are upright, so the wall at the laser's height is also at
the code's height: in plan view the camera's ray crosses the scan's points, and the code is at that crossing, at the
ray's height there::

    p = c + s r        s = n . (m - c) / (n . r)        sigma^2 = (sigma_w / |n . r|)^2 + (s sigma_r / |n . r|)^2

with the camera's centre c and unit ray r, the wall's horizontal unit normal n and a point m of it, fitted to the
laser's points around the crossing; sigma_w is that fit's, sigma_r (rad) the ray's.

There is no result where the crossing is at an edge (a door, the end of a cupboard), where the points around it do not
form a straight wall, or where ray and wall are nearly parallel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan

#: Radius (m) around the crossing of the points used for the wall, or where they are sparse a few on each side; at least
#: ``FEWEST_POINTS``.
AROUND_M = 0.2
FEWEST_POINTS = 5
#: Least extent (m) of the wall on both sides, the room of a page.
CLEAR_M = 0.05
#: Greatest residual (m, r.m.s.) of a straight wall.
ROUGHEST_M = 0.03
#: Least sine of the angle between ray and wall (10 degrees), and greatest steepness of the ray (70).
LEAST_SINE = math.sin(math.radians(10.0))
LEAST_LEVEL = math.cos(math.radians(70.0))

#: Least angle at which the laser may see a wall for neighbouring points to belong to one wall, noise apart.
_STEEPEST = 1.0 / LEAST_SINE
_NOISE_M = 0.03
#: Systematic error of the laser, which averaging does not reduce.
_LEAST_SIGMA_M = 0.005
#: The page may hang aslant on its wall.
_LEAST_SIGMA_RAD = 0.03


@dataclass(frozen=True, slots=True)
class WallPoint:
    """Intersection of ray and wall: ``point`` (x, y, z) m, ``range_m`` along the ray, ``sigma_m`` of the position.

    ``heading`` (rad) is the direction of the wall's normal on the camera's side, with ``heading_sigma`` (rad)."""

    point: tuple[float, float, float]
    range_m: float
    sigma_m: float
    heading: float
    heading_sigma: float


def scan_points(scan: LaserScan, X_OB_begin: Pose2, X_OB_end: Pose2) -> NDArray[np.float64]:
    """The ends (N, 2) of the rays of ``scan``, m in the frame O of the poses; NaN for rays without a return.

    The robot moves from ``X_OB_begin`` (first ray) to ``X_OB_end`` (last ray): each ray is placed by its own
    interpolated pose.
    """
    count = len(scan.ranges)
    ranges = scan.ranges.astype(np.float64)
    ranges[~((ranges >= scan.range_min) & (ranges <= scan.range_max))] = np.nan
    angles = scan.angle_min + scan.angle_increment * np.arange(count)
    in_laser = np.stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(count)), axis=-1)
    in_base = scan.X_BL.transform(in_laser)
    share = np.linspace(0.0, 1.0, count)
    moved = X_OB_begin.inverse() @ X_OB_end
    theta = X_OB_begin.theta + share * moved.theta
    c, s = np.cos(theta), np.sin(theta)
    x = X_OB_begin.x + share * (X_OB_end.x - X_OB_begin.x) + c * in_base[:, 0] - s * in_base[:, 1]
    y = X_OB_begin.y + share * (X_OB_end.y - X_OB_begin.y) + s * in_base[:, 0] + c * in_base[:, 1]
    return np.stack((x, y), axis=-1)


def wall_on_ray(
    points: NDArray[np.float64],
    laser: tuple[float, float],
    spacing_rad: float,
    camera: NDArray[np.float64],
    ray: NDArray[np.float64],
    ray_sigma_rad: float,
) -> WallPoint | None:
    """Intersection of ``ray`` (3,), a unit vector from ``camera`` (3,) m, with the first wall of ``points`` (N, 2), or
    None.

    ``points``: in the order of the laser's rays, ``spacing_rad`` apart, seen from ``laser`` (m); NaN: no return. All in
    one frame whose z points up; heights are above its ground, and a position below it is invalid.
    """
    level = math.hypot(ray[0], ray[1])
    if level < LEAST_LEVEL:
        return None
    forward = ray[:2] / level
    numbers = np.flatnonzero(np.isfinite(points).all(axis=1))
    seen = points[numbers]
    if len(seen) < FEWEST_POINTS:
        return None
    offset = seen - camera[:2]
    along, across = offset @ forward, offset @ np.array([-forward[1], forward[0]])
    crossing = _first_crossing(along, across)
    if crossing is None:
        return None
    joined = _joined(seen, numbers, laser, spacing_rad)
    window = _around(seen, joined, crossing[0])
    if window is None:
        return None
    middle, normal, sigma_wall, sigma_rad = window
    sine = float(normal @ forward)
    if abs(sine) < LEAST_SINE:
        return None
    distance = float(normal @ (middle - camera[:2])) / sine
    # The fitted line must pass near the crossing, else there is no wall.
    if abs(distance - crossing[1]) > AROUND_M or distance <= 0:
        return None
    range_m = distance / level
    x, y, z = (camera + range_m * ray).tolist()
    if z < 0:
        return None
    slant = abs(sine) * level
    sigma_m = math.hypot(sigma_wall / slant, range_m * ray_sigma_rad / slant)
    outward = -normal if sine > 0 else normal
    return WallPoint((x, y, z), range_m, sigma_m, math.atan2(outward[1], outward[0]), sigma_rad)


def _first_crossing(along: NDArray[np.float64], across: NDArray[np.float64]) -> tuple[int, float] | None:
    """The pair of points (the first's index) with the nearest crossing of the ray, and its distance (m), or None."""
    first, second = across[:-1], across[1:]
    pairs = np.flatnonzero((first <= 0) != (second <= 0))
    share = first[pairs] / (first[pairs] - second[pairs])
    distance = along[pairs] + share * (along[pairs + 1] - along[pairs])
    pairs, distance = pairs[distance > 0], distance[distance > 0]
    if not len(pairs):
        return None
    nearest = int(np.argmin(distance))
    return int(pairs[nearest]), float(distance[nearest])


def _joined(
    seen: NDArray[np.float64], numbers: NDArray[np.intp], laser: tuple[float, float], spacing_rad: float
) -> NDArray[np.bool_]:
    """(N - 1,) whether each point and the next are of one wall: neighbouring rays, no further apart than on a wall at
    the least angle."""
    gap = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    distance = np.linalg.norm(seen - np.asarray(laser), axis=1)
    farthest = np.maximum(distance[:-1], distance[1:]) * abs(spacing_rad) * _STEEPEST + _NOISE_M
    return np.asarray((np.diff(numbers) == 1) & (gap <= farthest))


def _around(
    seen: NDArray[np.float64], joined: NDArray[np.bool_], pair: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, float] | None:
    """A point, the unit normal, the sigma of the position (m) and of the direction (rad) of the line through the points
    around the crossing, which is between ``pair`` and the next; None where there is no straight wall."""
    if not joined[pair]:
        return None
    centre = 0.5 * (seen[pair] + seen[pair + 1])
    distance = np.linalg.norm(seen - centre, axis=1)
    # Points of a distant wall at a small angle are further apart.
    spacing = 2.0 * float(distance[pair])
    near = distance <= max(AROUND_M, 0.5 * (FEWEST_POINTS + 1) * spacing)
    begin, end = pair, pair + 2
    while begin > 0 and joined[begin - 1] and near[begin - 1]:
        begin -= 1
    while end < len(seen) and joined[end - 1] and near[end]:
        end += 1
    wall = seen[begin:end]
    if len(wall) < FEWEST_POINTS or min(distance[begin], distance[end - 1]) < CLEAR_M:
        return None
    middle = wall.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov((wall - middle).T, bias=True))
    rough = math.sqrt(max(0.0, float(spread[0])))
    if rough > ROUGHEST_M:
        return None
    sigma_m = max(_LEAST_SIGMA_M, rough / math.sqrt(len(wall)))
    # Of a line through points spread along it by so much, by their noise across it
    return middle, axes[:, 0], sigma_m, math.hypot(_LEAST_SIGMA_RAD, sigma_m / math.sqrt(float(spread[1])))
