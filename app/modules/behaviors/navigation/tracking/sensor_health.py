"""Checks of scan and depth images before driving by them: age, and dead depth images (the thesis's silent failure of
the Kinect)."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from app.base.geometry import CameraModel
from app.messages import Image, LaserScan

#: Stride of the sampled rows and columns.
_STEP = 8
#: Greatest depth (m) to which a depth camera may be blind.
_BLIND_M = 0.7
#: Where the laser measures nothing, a wall is this far away (m).
_OPEN_M = 1e3
#: Sampled rows and columns of a camera's view.
_LOOKS = 9
#: A wall's point serves so far aside (rad).
_BESIDE_RAD = math.radians(2.0)


@dataclass(frozen=True, slots=True)
class DepthHealth:
    """State of the depth camera: ``good``: stamp of the newest live image, None before the first; ``problem``: the
    fault of the newest, "" for none; ``digest``: hash of its pixels."""

    good: float | None = None
    problem: str = ""
    digest: int = 0


def update_depth_health(watch: DepthHealth, image: Image, scan: LaserScan | None = None) -> DepthHealth:
    """Check one more image: all zero, constant, or equal to the one before means dead.

    A wall nearer than a depth camera's least range gives zeros too: ``scan`` excuses them if it shows such a wall.
    """
    if image.depth is None:
        return DepthHealth(watch.good, "pictures come without depth", watch.digest)
    pixels = np.ascontiguousarray(image.depth[::_STEP, ::_STEP])
    digest = zlib.crc32(pixels.tobytes())
    problem = ""
    if not pixels.any():
        if scan is None or not _stands_before_a_wall(image, scan):
            problem = "depth pictures are all zero"
    elif int(pixels.min()) == int(pixels.max()):
        problem = "depth pictures show one and the same distance everywhere"
    elif watch.good is not None and digest == watch.digest:
        problem = "the same depth picture comes over and over"
    return DepthHealth(watch.good if problem else image.stamp, problem, digest)


def unfit(
    now: float,
    scan_stamp: float | None,
    depth: DepthHealth | None,
    limit_s: float = 0.3,
) -> str:
    """Reason not to drive, in words that stay the same while it lasts; "" for none. ``depth`` None: a body without
    depth camera.

    Sensor data must not be older than ``limit_s``: the newest scan, and the newest live depth image.
    """
    if scan_stamp is None:
        return "no laser scan has come yet"
    if not now - scan_stamp >= -limit_s:
        return "the laser's stamps are not of the robot's clock"
    if now - scan_stamp > limit_s:
        return f"the laser scan is too old: the laser or this computer is too slow; {limit_s:g} s is the limit"
    if depth is None:
        return ""
    if depth.good is None:
        return depth.problem or "no depth picture has come yet"
    if not now - depth.good >= -limit_s:
        return "the depth camera's stamps are not of the robot's clock"
    if now - depth.good > limit_s:
        if depth.problem:
            return depth.problem
        return f"the depth picture is too old: the camera or this computer is too slow; {limit_s:g} s is the limit"
    return ""


def _stands_before_a_wall(image: Image, scan: LaserScan) -> bool:
    """Whether all that the camera looks at, where the scan measures, is nearer than its least range: walls upright at
    the scan's points, and the floor before them. The head may be turned and tilted.
    """
    camera, X_BC = image.camera, image.X_BC
    if not isinstance(camera, CameraModel):
        return False
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    # A ray without a return is no wall.
    measured = np.isfinite(scan.ranges) & (scan.ranges >= scan.range_min)
    ranges = np.where(measured, scan.ranges, np.float32(_OPEN_M))
    at = np.stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros_like(ranges)), axis=-1)
    points = scan.X_BL.transform(at.astype(np.float64)) - X_BC.translation
    azimuths, walls_m = np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 0], points[:, 1])
    rows, columns = (np.linspace(0.05, 0.95, _LOOKS) * size for size in (camera.height, camera.width))
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    looks = camera.rays(pixels) @ X_BC.rotation.T
    looks /= looks @ X_BC.rotation[:, 2:]  # as far as 1 m of depth reaches
    level = np.hypot(looks[:, 0], looks[:, 1])
    off = np.abs(np.arctan2(looks[:, 1], looks[:, 0])[:, None] - azimuths)
    off = np.minimum(off, 2.0 * math.pi - off)
    nearest = off.argmin(axis=1)
    covered = off[np.arange(len(looks)), nearest] < max(scan.angle_increment, _BESIDE_RAD)
    with np.errstate(divide="ignore"):
        wall_m = walls_m[nearest] / level
        floor_m = np.where(looks[:, 2] < 0.0, X_BC.translation[2] / -looks[:, 2], np.inf)
    return bool(covered.any() and (np.minimum(wall_m, floor_m)[covered] < _BLIND_M).all())
