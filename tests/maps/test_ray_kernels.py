"""Rays on an occupancy grid."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.maps.ray_kernels import cast_grid


def test_rays_end_in_the_middle_of_what_they_meet_and_are_lost_in_the_unknown() -> None:
    occupied, unknown = np.zeros((9, 20), np.uint8), np.zeros((9, 20), np.uint8)
    occupied[:, 15] = 1
    unknown[:, 2] = 1
    angles = np.array([0.0, math.pi, math.pi / 2, math.atan2(1.0, 4.0)])
    ranges = cast_grid(occupied, unknown, 8.5, 4.5, angles, 30.0)
    assert ranges[0] == pytest.approx(7.0)
    assert np.isnan(ranges[1])
    assert np.isnan(ranges[2]), "beyond the grid nothing is known"
    assert ranges[3] == pytest.approx(7.0 / math.cos(angles[3]), abs=0.01)
    assert cast_grid(occupied, unknown, 8.5, 4.5, angles[:1], 5.0)[0] == 5.0
