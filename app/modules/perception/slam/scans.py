"""Scans made ready for matching: points with normals, the motion during the sweep taken out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """How a laser looks: ``angles`` (N,) float64 rad of its rays, about z of its frame, in order of measuring.

    Readings below ``range_min`` or not a number are none; from ``range_max`` (m) on, nothing was hit. ``X_BL`` is the
    laser in ``base_link``.
    """

    angles: NDArray[np.float64]
    range_min: float
    range_max: float
    X_BL: Pose2 = Pose2()
