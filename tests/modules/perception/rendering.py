"""Kinect images of a QR poster, rendered from known geometry (perspective, blur, noise, depth), for tests."""

from __future__ import annotations

import math

import cv2
import numpy as np
import segno
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image

#: Kinect: 57 x 43 degrees at 640 x 480 (f = 589 px).
KINECT = CameraModel(640, 480, 589.0, 589.0, 319.5, 239.5)
#: The camera's optical frame in base_link: 1.3 m up, 0.1 m forward, level.
X_BC = Pose3.from_translation_rpy((0.1, 0.0, 1.3), (-math.pi / 2, 0.0, -math.pi / 2))
#: Edge of a code (m), quiet zone not counted.
CODE_M = 0.18


def facing(x: float, y: float, z: float, turn: float = 0.0) -> Pose3:
    """X_OQ of a code at (x, y, z) whose front looks towards -x, turned by ``turn`` rad about the vertical.

    In Q, x points right and y down as printed, z into the wall.
    """
    return Pose3.from_translation_rpy((x, y, z), (0.0, 0.0, turn)) @ Pose3.from_translation_rpy(
        (0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2)
    )


def kinect_image(
    stamp: float,
    X_OB: Pose2,
    posters: dict[str, Pose3],
    *,
    wall_m: float = 4.5,
    blur_px: float = 0.7,
    noise: float = 5.0,
    depth_noise: bool = True,
    seed: int = 0,
) -> Image:
    """What a Kinect on a robot at ``X_OB`` sees of ``posters`` (text -> X_OQ) before a grey wall ``wall_m`` away."""
    rng = np.random.default_rng(seed)
    color = np.full((KINECT.height, KINECT.width), 120.0, np.float32)
    depth = np.full(color.shape, wall_m, np.float64)
    X_OC = X_OB.to_pose3() @ X_BC
    for text, X_OQ in posters.items():
        _draw(color, depth, text, X_OC.inverse() @ X_OQ)
    soft = cv2.GaussianBlur(color, (0, 0), blur_px)
    noisy = np.clip(soft[..., None] + rng.normal(0, noise, (*soft.shape, 3)), 0, 255).astype(np.uint8)
    if depth_noise:
        depth = depth + rng.normal(0, 1, depth.shape) * (0.0012 + 0.0019 * (depth - 0.4) ** 2)
    return Image(stamp, "kinect_optical_frame", noisy, np.round(depth * 1000).astype(np.uint16), KINECT, X_BC)


def _draw(color: NDArray[np.float32], depth: NDArray[np.float64], text: str, X_CQ: Pose3) -> None:
    code = segno.make(text, error="m", micro=False)
    scale, border = 16, 4
    page = np.array([[0 if dark else 255 for dark in row] for row in code.matrix_iter(scale=scale, border=border)])
    side = page.shape[0]
    half = 0.5 * CODE_M * side / (side - 2 * border * scale)
    square = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    corners = KINECT.project(X_CQ.transform(square)).astype(np.float32)
    edge = side - 0.5
    flat = np.array([(-0.5, -0.5), (edge, -0.5), (edge, edge), (-0.5, edge)], np.float32)
    # Only the box around the poster is drawn, at four times the resolution and then averaged, as a sensor's pixel
    # averages what falls on it.
    u0, v0 = np.clip(np.floor(corners.min(axis=0)).astype(int) - 2, 0, (KINECT.width - 1, KINECT.height - 1))
    u1, v1 = np.clip(np.ceil(corners.max(axis=0)).astype(int) + 3, 1, (KINECT.width, KINECT.height))
    size = (int(u1 - u0), int(v1 - v0))
    big = (size[0] * 4, size[1] * 4)
    fine = cv2.getPerspectiveTransform(flat, ((corners - (u0, v0)) * 4 + 1.5).astype(np.float32))
    drawn = cv2.warpPerspective(page.astype(np.float32), fine, big, flags=cv2.INTER_LINEAR, borderValue=-1.0)
    inside = cv2.warpPerspective(np.ones(page.shape, np.float32), fine, big, flags=cv2.INTER_NEAREST)
    share = cv2.resize(inside, size, interpolation=cv2.INTER_AREA)
    value = cv2.resize(np.where(inside > 0, np.clip(drawn, 0, 255), 0), size, interpolation=cv2.INTER_AREA)
    box = (slice(v0, v1), slice(u0, u1))
    color[box] = color[box] * (1 - share) + value
    v, u = np.mgrid[v0:v1, u0:u1]
    rays = KINECT.back_project(np.stack((u, v), -1).astype(float), np.ones(u.shape))
    normal = X_CQ.rotation[:, 2]
    along = (normal @ X_CQ.translation) / (rays @ normal)
    depth[box] = np.where(share > 0.5, along, depth[box])
