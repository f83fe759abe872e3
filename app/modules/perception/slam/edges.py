"""How much an edge of the graph says that a keyframe got by following the robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.slam.information import Information, diagonal
from app.modules.perception.slam.scan_matching import ScanFit

#: An edge of so small a share of the scan says little, and one of no share next to nothing.
_SURE_SHARE = 0.6
#: Information (1/m^2, 1/rad^2) of these.
_UNSURE = diagonal(50.0, 50.0, 800.0)
_LOST = diagonal(0.25, 0.25, 4.0)
#: No edge says less: a graph must be solvable.
_LEAST = diagonal(1e-4, 1e-4, 0.1)


def edge_information(
    fit: ScanFit | None, step_sigmas: tuple[float, float], covariance: NDArray[np.float64], lost_below: float
) -> Information:
    """Of a keyframe that ``fit`` says to be there; below ``lost_below`` (share of the scan), odometry alone does.

    ``step_sigmas`` (m, rad) held the fit back, ``covariance`` (3, 3; m^2, rad^2) is what is known of the pose since
    scans fitted last.
    """
    if fit is None:
        return _LOST
    if fit.inliers > _SURE_SHARE:
        return fit.edge_information(step_sigmas)
    if fit.inliers >= lost_below:
        return _UNSURE
    # As sure as odometry is since scans fitted last, and no surer than not to matter beside a loop.
    x, y, theta = np.diagonal(covariance).tolist()
    place = max(min(_LOST[0], 1.0 / (x + y)), _LEAST[0])
    return diagonal(place, place, max(min(_LOST[5], 1.0 / theta), _LEAST[5]))
