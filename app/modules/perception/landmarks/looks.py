"""Whether an image should have shown a landmark: a pure function. Only such a look, in vain, says that it is gone."""

from __future__ import annotations

import math

import numpy as np

from app.base.geometry import CameraModel, Pose3
from app.messages import Image
from app.modules.perception.landmarks.sightings import FloatArray

#: Farthest (m) and most aslant (rad) that every code is read, one of 0.18 m on a page.
FARTHEST_M = 2.0
MOST_ASLANT_RAD = math.radians(30.0)
#: Half a side of what must be in the image (m), and how much nearer something may be before it hides the code (m).
_HALF_M = 0.12
_HIDDEN_M = 0.15
#: Share of the pixels that must have a depth, and least mean brightness, of 255.
_MEASURED = 0.3
_LIT = 40.0


def should_show(image: Image, X_FC: Pose3, p_FQ: FloatArray, heading: float) -> bool:
    """Whether ``image``, taken by a camera with depth at ``X_FC``, should show a code at ``p_FQ`` (3,) m on an upright
    surface whose outward normal has the direction ``heading`` (rad): near, not aslant, wholly in the image, lit, and
    with nothing before it."""
    camera, depth = image.camera, image.depth
    if depth is None or not isinstance(camera, CameraModel):
        return False
    normal = np.array([math.cos(heading), math.sin(heading), 0.0])
    towards = X_FC.translation - p_FQ
    range_m = float(np.linalg.norm(towards))
    if not 0.0 < range_m <= FARTHEST_M or float(normal @ towards) < range_m * math.cos(MOST_ASLANT_RAD):
        return False
    across, up = np.array([-normal[1], normal[0], 0.0]), np.array([0.0, 0.0, 1.0])
    corners = np.array([p_FQ + _HALF_M * (a * across + b * up) for a in (-1, 1) for b in (-1, 1)])
    seen = X_FC.inverse().transform(corners)
    pixels = camera.project(seen)
    if not (np.isfinite(pixels) & (pixels >= 0) & (pixels <= (camera.width - 1, camera.height - 1))).all():
        return False
    (u0, v0), (u1, v1) = pixels.min(axis=0).astype(int).tolist(), (pixels.max(axis=0).astype(int) + 1).tolist()
    near = depth[v0:v1, u0:u1]
    measured = near[near > 0]
    if len(measured) < _MEASURED * near.size or float(image.color[v0:v1, u0:u1].mean()) < _LIT:
        return False
    # What is farther than expected hides nothing: the wall itself may be gone.
    return float(np.percentile(measured, 10)) * 1e-3 > float(seen[:, 2].min()) - _HIDDEN_M
