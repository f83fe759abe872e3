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
#: Greatest distance (m along the floor) at which a depth camera may be blind to a wall.
_BLIND_M = 0.7


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
    """Whether all scan points in the camera's field of view are nearer than its least range."""
    if not isinstance(image.camera, CameraModel):
        return False
    half = math.atan(0.5 * image.camera.width / image.camera.fx)
    ahead = image.X_BC.rotation[:, 2]
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    # A ray without a return is no wall.
    measured = np.isfinite(scan.ranges) & (scan.ranges >= scan.range_min)
    ranges = np.where(measured, scan.ranges, np.float32(1e3))
    at = np.stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros_like(ranges)), axis=-1)
    rays = scan.X_BL.transform(at.astype(np.float64)) - image.X_BC.translation
    off = np.arctan2(rays[:, 1], rays[:, 0]) - math.atan2(ahead[1], ahead[0])
    seen = np.abs((off + math.pi) % (2.0 * math.pi) - math.pi) < 0.9 * half
    return bool(seen.any() and (np.hypot(rays[seen, 0], rays[seen, 1]) < _BLIND_M).all())
