"""Pictures of QR posters, traced ray by ray from known geometry, for benchmarks and tests.

Every pixel is the mean of rays spread evenly over it, as a sensor's pixel averages what falls on it; then the lens's
blur (a Gaussian) and the sensor's noise are laid over it. The page is US-Letter paper with the code in its middle
(thesis 4.2), before a wall with some texture.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import cv2
import numpy as np
import segno
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3

#: Kinect: 57 x 43 degrees at 640 x 480 (f = 589 px).
KINECT = CameraModel(640, 480, 589.0, 589.0, 319.5, 239.5)
#: The panoramic camera: the hemisphere in front, stretched over its sensor (thesis 4.2).
PANORAMA = FisheyeModel.from_fov(1024, 768, math.pi, math.pi)
#: Edge of a code (m), its quiet zone not counted.
CODE_M = 0.18
#: A text that takes 25 x 25 modules, as the posters of a tour do.
TEXT = "hbba:tour/stop-2/robot-lab"

_LETTER_M = (0.2159, 0.2794)
_RAYS = 4
_PX_PER_MODULE = 16


def facing_camera(
    distance_m: float, azimuth: float = 0.0, elevation: float = 0.0, tilt: float = 0.0, roll: float = 0.0
) -> Pose3:
    """X_CQ of a page ``distance_m`` along the direction ``azimuth`` (right) and ``elevation`` (up) of an optical frame,
    face on, then turned by ``tilt`` about its own vertical and by ``roll`` in its plane (rad).

    In Q, x points right and y down as printed, z into the page.
    """
    turned = Pose3(_about_y(azimuth) @ _about_x(elevation), np.zeros(3))
    place = Pose3(np.eye(3), np.array([0.0, 0.0, distance_m]))
    own = Pose3(_about_y(tilt) @ _about_z(roll), np.zeros(3))
    return turned @ place @ own


def picture(
    camera: CameraModel | FisheyeModel,
    posters: Mapping[str, Pose3],
    *,
    blur_px: float = 0.7,
    noise: float = 5.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """What ``camera`` sees of ``posters`` (text: X_CQ), (H, W, 3) uint8, RGB; ``noise`` is 1-sigma, in grey levels."""
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(70, 190, (camera.height // 48 + 2, camera.width // 48 + 2)).astype(np.float32)
    sharp = cv2.resize(coarse, (camera.width, camera.height), interpolation=cv2.INTER_CUBIC).astype(np.float32)
    for text, X_CQ in posters.items():
        _draw(sharp, camera, text, X_CQ)
    grey = cv2.GaussianBlur(sharp, (0, 0), blur_px)
    color = grey[..., None] + rng.normal(0, noise, (*grey.shape, 3)).astype(np.float32)
    return np.clip(np.rint(color), 0, 255).astype(np.uint8)


def page(text: str) -> tuple[NDArray[np.float32], float]:
    """The page's grey levels (H, W) float32, and its pixels per metre."""
    code = segno.make(text, error="m", micro=False)
    modules = np.array([[0 if dark else 255 for dark in row] for row in code.matrix_iter(border=0)], np.float32)
    drawn = np.kron(modules, np.ones((_PX_PER_MODULE, _PX_PER_MODULE), np.float32))
    per_m = len(drawn) / CODE_M
    width, height = (round(edge * per_m) for edge in _LETTER_M)
    sheet = np.full((max(height, len(drawn)), max(width, len(drawn))), 255, np.float32)
    top, left = (sheet.shape[0] - len(drawn)) // 2, (sheet.shape[1] - len(drawn)) // 2
    sheet[top : top + len(drawn), left : left + len(drawn)] = drawn
    # Pages are printed on white paper whose margin is smaller than a code's quiet zone should be.
    return sheet, per_m


def _draw(grey: NDArray[np.float32], camera: CameraModel | FisheyeModel, text: str, X_CQ: Pose3) -> None:
    sheet, per_m = page(text)
    half_w, half_h = 0.5 * sheet.shape[1] / per_m, 0.5 * sheet.shape[0] / per_m
    along = np.linspace(-1, 1, 9)
    edge = np.array(
        [(x * half_w, y * half_h, 0.0) for a in along for x, y in ((a, -1.0), (a, 1.0), (-1.0, a), (1.0, a))]
    )
    outline = camera.project(X_CQ.transform(edge))
    outline = outline[np.isfinite(outline).all(axis=1)]
    if not len(outline):
        return
    limit = (camera.width, camera.height)
    u0, v0 = np.clip(np.floor(outline.min(axis=0)).astype(int) - 1, 0, limit)
    u1, v1 = np.clip(np.ceil(outline.max(axis=0)).astype(int) + 2, 0, limit)
    if u1 <= u0 or v1 <= v0:
        return
    offsets = (np.arange(_RAYS) + 0.5) / _RAYS - 0.5
    v, u = np.meshgrid(
        (np.arange(v0, v1)[:, None] + offsets).ravel(), (np.arange(u0, u1)[:, None] + offsets).ravel(), indexing="ij"
    )
    rays = camera.rays(np.stack((u, v), axis=-1)) @ X_CQ.rotation
    origin = -X_CQ.rotation.T @ X_CQ.translation
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = -origin[2] / rays[..., 2]
        x, y = origin[0] + reach * rays[..., 0], origin[1] + reach * rays[..., 1]
        on = (reach > 0) & (np.abs(x) < half_w) & (np.abs(y) < half_h)
    column = np.where(on, (x + half_w) * per_m - 0.5, 0).astype(np.float32)
    row = np.where(on, (y + half_h) * per_m - 0.5, 0).astype(np.float32)
    seen = np.where(on, cv2.remap(sheet, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), 0)
    shape = (v1 - v0, _RAYS, u1 - u0, _RAYS)
    value = seen.astype(np.float32).reshape(shape).mean(axis=(1, 3))
    share = on.astype(np.float32).reshape(shape).mean(axis=(1, 3))
    box = (slice(v0, v1), slice(u0, u1))
    # Print is not black, paper is not white: 25 to 225.
    grey[box] = grey[box] * (1 - share) + value * (200 / 255) + 25 * share


def _about_x(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([(1, 0, 0), (0, c, -s), (0, s, c)])


def _about_y(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([(c, 0, s), (0, 1, 0), (-s, 0, c)])


def _about_z(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])
