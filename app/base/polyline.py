"""Lines of points in the plane. Pure functions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: A thinned path has at most so many points.
MOST_POINTS = 200
_HEADING_STEP = 0.01


def thinned_path(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """At most ``MOST_POINTS`` of ``points`` (N, 2), both ends among them: those where it turns, then evenly."""
    if len(points) > 2:
        steps = np.diff(points, axis=0)
        headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        # Between two that are kept, the heading stays within one step: a wide bend is no straight line.
        turns = np.diff(np.floor(headings / _HEADING_STEP)) != 0
        points = points[np.concatenate([[True], turns, [True]])]
    if len(points) > MOST_POINTS:
        points = points[np.linspace(0, len(points) - 1, MOST_POINTS).round().astype(np.intp)]
    return points
