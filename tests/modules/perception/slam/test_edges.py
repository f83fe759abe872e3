"""What an edge says: much where the scan fitted, no more than odometry where it did not."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.edges import edge_information
from app.modules.perception.slam.information import Information, variance_m2
from app.modules.perception.slam.scan_matching import ScanFit


def of(inliers: float, sigma_m: float = 0.1) -> Information:
    fit = ScanFit(Pose2(), inliers, 1.0, 0.01, np.diag([1e4, 1e4, 1e5]))
    return edge_information(fit, (0.1, 0.1), np.diag([sigma_m**2, sigma_m**2, 0.01]), 0.25)


def test_the_better_a_scan_fitted_the_more_an_edge_says() -> None:
    spreads = [variance_m2(of(inliers)) for inliers in (0.95, 0.5, 0.1)]
    assert spreads == sorted(spreads)
    assert spreads[2] > 10 * spreads[1] > 100 * spreads[0]


@pytest.mark.parametrize(("sigma_m", "at_least"), [(0.1, 2.0), (5.0, 7.0), (1e6, 100.0)])
def test_a_scan_that_fits_nowhere_is_as_sure_as_odometry_and_no_surer(sigma_m: float, at_least: float) -> None:
    assert at_least <= variance_m2(of(0.1, sigma_m)) ** 0.5 < 1000.0
