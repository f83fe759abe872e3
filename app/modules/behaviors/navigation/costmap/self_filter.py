"""The robot's own arms in a depth image are no obstacles: their pixels count as not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel
from app.base.moving_shapes import Capsules
from app.messages import Image, read_only

#: Room (m) about the arms for errors of joints, depth and time.
MARGIN_M = 0.05
#: A capsule that comes nearer (m) to the camera's plane may cover any part of the image.
_NEAREST_M = 0.05


def self_filtered(image: Image, own: Capsules, margin_m: float = MARGIN_M) -> Image:
    """``image`` without the depth of points in the capsules ``own`` (in ``base_link``, at the image's stamp), or within
    ``margin_m`` of them; the same image where there are none, or where it has no depth of a pinhole camera."""
    camera, depth = image.camera, image.depth
    if depth is None or not isinstance(camera, CameraModel):
        return image
    X_CB = image.X_BC.inverse()
    hit: NDArray[np.bool_] | None = None
    for (begin, end), radius in zip(own.ends, own.radii, strict=True):
        middle = np.asarray(X_CB.transform(0.5 * (begin + end)), dtype=np.float64)
        around = float(radius + 0.5 * np.linalg.norm(end - begin) + margin_m)
        window = _window(camera, middle, around)
        if window is None:
            continue
        nearest, furthest = 1000.0 * (middle[2] - around), 1000.0 * (middle[2] + around)
        v, u = np.nonzero((depth[window] > max(nearest, 0.0)) & (depth[window] < furthest))
        v, u = v + window[0].start, u + window[1].start
        points = camera.back_project(np.stack((u, v), axis=-1).astype(np.float64), depth[v, u] * 0.001)
        capsule = Capsules(np.stack((begin, end))[None], np.array([radius]))
        inside = capsule.contains(np.asarray(image.X_BC.transform(points), dtype=np.float64), margin_m)
        if inside.any():
            hit = np.zeros(depth.shape, dtype=np.bool_) if hit is None else hit
            hit[v[inside], u[inside]] = True
    if hit is None:
        return image
    return replace(image, depth=read_only(np.where(hit, np.uint16(0), depth)))


def _window(camera: CameraModel, middle: NDArray[np.float64], around_m: float) -> tuple[slice, slice] | None:
    """Rows and columns of the image within which a sphere may be seen: its ``middle`` (3,) m in the optical frame."""
    x, y, z = (float(value) for value in middle)
    if z + around_m <= 0.0:
        return None
    if z - around_m < _NEAREST_M:
        return slice(0, camera.height), slice(0, camera.width)
    bounds: list[slice] = []
    for centre, focal, principal, length in (
        (y, camera.fy, camera.cy, camera.height),
        (x, camera.fx, camera.cx, camera.width),
    ):
        low, high = centre - around_m, centre + around_m
        first = principal + focal * min(low / (z - around_m), low / (z + around_m))
        last = principal + focal * max(high / (z - around_m), high / (z + around_m))
        begin, end = max(int(first), 0), min(int(last) + 2, length)
        if begin >= end:
            return None
        bounds.append(slice(begin, end))
    return bounds[0], bounds[1]
