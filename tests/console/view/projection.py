"""Where a camera of the 3D view has a point in its picture: by a matrix, as browsers reckon it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from app.console.view.viewpoints import Shot


def projected(camera: Shot, aspect: float, p: ArrayLike) -> tuple[float, float]:
    """Shares of the width from the left and of the height from the top, for ``p`` (3,) in the frame of ``camera`` and a
    picture of that width over height."""
    back = np.array(camera.eye) - camera.target
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    x, y, z = np.stack([right, np.cross(back, right), back]) @ (np.asarray(p) - camera.eye)
    scale = 1.0 / math.tan(camera.fov / 2)
    return 0.5 + 0.5 * scale / aspect * x / -z, 0.5 - 0.5 * scale * y / -z
