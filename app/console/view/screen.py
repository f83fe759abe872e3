"""The camera's picture on a curved screen around the robot's camera: what each strip shows, and where it is. Pure.

The screen is part of a cylinder about the camera, upright in its picture; strips of it are flat. The picture is bent so
that from the camera everything on it is in the direction where it was seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel

STRIPS = 8
RADIUS_M = 1.0
#: Widest and highest picture of a strip (px): more is not seen.
_STRIP_PX, _HEIGHT_PX = 80, 480


@dataclass(frozen=True, slots=True, eq=False)
class CurvedScreen:
    """``azimuths`` (rad, to the right) of the strips' middles, ``below`` (m) the optical axis; ``size`` (m) of each.

    ``columns`` and ``rows`` (H, W) float32: from which pixel each pixel of all strips, side by side, comes.
    """

    azimuths: tuple[float, ...]
    below: float
    size: tuple[float, float]
    columns: NDArray[np.float32]
    rows: NDArray[np.float32]

    def strips(self, picture: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        """What each strip shows of ``picture`` (H, W, 3)."""
        bent = cv2.remap(picture, self.columns, self.rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return [np.ascontiguousarray(part) for part in np.split(np.asarray(bent, np.uint8), STRIPS, axis=1)]


def curved_screen(camera: CameraModel, width: int, height: int) -> CurvedScreen:
    """The screen for pictures of ``camera`` that are ``width`` x ``height`` px."""
    scale = width / camera.width
    fx, fy = scale * camera.fx, scale * camera.fy
    cx, cy = scale * (camera.cx + 0.5) - 0.5, scale * (camera.cy + 0.5) - 0.5
    left, right = math.atan((-0.5 - cx) / fx), math.atan((width - 0.5 - cx) / fx)
    step = (right - left) / STRIPS
    # As high as the picture is in its middle.
    top, bottom = (-0.5 - cy) / fy, (height - 0.5 - cy) / fy
    across, down = STRIPS * min(_STRIP_PX, max(1, width // STRIPS)), min(_HEIGHT_PX, height)
    azimuth = left + (right - left) * (np.arange(across) + 0.5) / across
    slope = top + (bottom - top) * (np.arange(down) + 0.5) / down
    columns = np.broadcast_to(cx + fx * np.tan(azimuth), (down, across))
    rows = cy + fy * slope[:, None] / np.cos(azimuth)
    return CurvedScreen(
        tuple(left + (number + 0.5) * step for number in range(STRIPS)),
        0.5 * RADIUS_M * (top + bottom),
        (2 * RADIUS_M * math.tan(step / 2), RADIUS_M * (bottom - top)),
        np.ascontiguousarray(columns, np.float32),
        np.ascontiguousarray(rows, np.float32),
    )
