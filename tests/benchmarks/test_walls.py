"""A building's squareness is measured on the walls that scans see, under a trajectory's headings."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.walls import squareness, wall_pieces

ANGLES = np.radians(np.arange(-90.0, 90.0))


def corner(turned: float, apart: float) -> NDArray[np.float64]:
    """Ranges (m) in a corner of walls 3 m off; seen by a robot ``turned`` (rad); ``apart``: between the walls (rad)."""
    world = ANGLES + turned
    toward = np.stack((np.cos(world), np.cos(world - apart)))
    return 3.0 / np.maximum(toward, 1e-6).max(axis=0)


@pytest.mark.parametrize("skew_deg", [0.0, 0.5, -1.0])
def test_skew_walls_are_measured(skew_deg: float) -> None:
    headings = np.array([0.1, 0.4, 0.7])
    pieces = [wall_pieces(corner(heading, np.pi / 2 + np.radians(skew_deg)), ANGLES) for heading in headings]
    assert sum(map(len, pieces)) > 40
    found = squareness(headings, pieces)
    assert found.skew_deg == pytest.approx(abs(skew_deg), abs=0.05)  # a piece may reach round the corner


def test_headings_that_are_off_stray() -> None:
    headings = np.array([0.1, 0.4, 0.7])
    pieces = [wall_pieces(corner(heading, np.pi / 2), ANGLES) for heading in headings]
    assert squareness(headings, pieces).astray_deg == pytest.approx(0.0, abs=0.01)
    assert squareness(headings + np.radians([0.0, 1.0, 0.0]), pieces).astray_deg > 0.2


def test_nothing_seen_is_no_wall() -> None:
    assert wall_pieces(np.full(180, np.inf), ANGLES).shape == (0, 2)
