"""Coloured points from a colour image and its depth: a pure function."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.messages import Image


def grid_step(camera: CameraModel | FisheyeModel, max_points: int) -> int:
    """The smallest pixel step at which a grid over the image has at most ``max_points`` points."""
    step = max(1, math.isqrt(camera.width * camera.height // max_points))
    while math.ceil(camera.width / step) * math.ceil(camera.height / step) > max_points:
        step += 1
    return step


def colored_cloud(image: Image, max_points: int) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Points (N, 3) float32 m in ``base_link`` at the image's stamp, and their colours (N, 3) uint8 RGB.

    A regular grid of the image with at most ``max_points`` pixels (>= 1) is back-projected through the camera and
    ``X_BC``; pixels without depth are left out, so N is often less. Raises ValueError for an image without depth.
    """
    if image.depth is None:
        raise ValueError(f"the camera {image.frame} gives no depth: no point cloud can be built from it")
    step = grid_step(image.camera, max_points)
    # The grid is centred, so that no border of up to a whole step is cut off on one side.
    rows = _centred(image.camera.height, step)
    columns = _centred(image.camera.width, step)
    depth = image.depth[rows][:, columns]
    v, u = np.nonzero(depth)
    pixels = np.stack((columns[u], rows[v]), axis=-1).astype(np.float32)
    z = depth[v, u].astype(np.float32) * np.float32(0.001)
    return _in_base(image.X_BC, image.camera.back_project(pixels, z)), image.color[rows[v], columns[u]]


def _centred(length: int, step: int) -> NDArray[np.intp]:
    count = math.ceil(length / step)
    return (length - 1 - (count - 1) * step) // 2 + step * np.arange(count)


def _in_base(X_BC: Pose3, points: NDArray[np.floating]) -> NDArray[np.float32]:
    return X_BC.transform(points).astype(np.float32, copy=False)
