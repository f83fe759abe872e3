"""Information of an edge between consecutive keyframes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.slam.information import Information, diagonal
from app.modules.perception.slam.scan_matching import ScanFit

#: Shares of matched points at which an edge carries little, and almost no information.
_SURE_SHARE = 0.6
#: Information (1/m^2, 1/rad^2) at these shares.
_UNSURE = diagonal(50.0, 50.0, 800.0)
_LOST = diagonal(0.25, 0.25, 4.0)
#: Least information of an edge: the graph must be solvable.
_LEAST = diagonal(1e-4, 1e-4, 0.1)


def edge_information(
    fit: ScanFit | None, step_sigmas: tuple[float, float], covariance: NDArray[np.float64], lost_below: float
) -> Information:
    """Information of an edge to a keyframe placed by ``fit``; below ``lost_below`` (share of the scan), by odometry
    alone.

    ``step_sigmas`` (m, rad): prior of the fit. ``covariance`` (3, 3; m^2, rad^2): of the pose since scans fitted last.
    """
    if fit is None:
        return _LOST
    if fit.inliers > _SURE_SHARE:
        return fit.edge_information(step_sigmas)
    if fit.inliers >= lost_below:
        return _UNSURE
    # Odometry's covariance since scans fitted last, with a least information so that it does not vanish beside a loop.
    x, y, theta = np.diagonal(covariance).tolist()
    place = max(min(_LOST[0], 1.0 / (x + y)), _LEAST[0])
    return diagonal(place, place, max(min(_LOST[5], 1.0 / theta), _LEAST[5]))
