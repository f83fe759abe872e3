"""The outline of the next two seconds: where the body will be, and whether it meets anything."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.console.view.outlook import CLEAR, MEETS, SOON, ahead, outlook
from app.messages import Twist

SQUARE = np.array([(0.3, -0.3), (0.3, 0.3), (-0.3, 0.3), (-0.3, -0.3)])
NOTHING = np.zeros((0, 2))


def test_a_body_on_an_arc_is_where_many_small_steps_lead() -> None:
    twist = Twist(0.0, 0.4, 0.8, lateral_mps=0.1)
    pose = ahead(twist, 0.001)
    for _ in range(1999):
        pose = pose @ ahead(twist, 0.001)
    there = ahead(twist, 2.0)
    assert (pose.x, pose.y) == pytest.approx((there.x, there.y), abs=1e-6)


@pytest.mark.parametrize(
    ("distance", "color"), [(0.6, SOON), (0.95, MEETS), (1.3, CLEAR)], ids=["soon", "later", "not at all"]
)
def test_its_colour_says_when_it_meets_what_the_laser_sees(distance: float, color: tuple[int, int, int]) -> None:
    seen = outlook(SQUARE, Twist(0.0, 0.4, 0.0), np.array([[distance, 0.1]]))
    assert seen is not None
    assert seen.color == color
    # The last outline is 0.8 m ahead, its ribbon on it.
    assert seen.vertices[:, 0].max() == pytest.approx(1.1, abs=0.06)
    assert seen.faces.max() == len(seen.vertices) - 1


def test_what_is_beside_the_way_or_in_the_body_itself_is_not_met() -> None:
    seen = outlook(SQUARE, Twist(0.0, 0.4, 0.0), np.array([[0.5, 0.4], [0.5, -0.4], [0.1, 0.0], [-0.6, 0.0]]))
    assert seen is not None
    assert seen.contact_s is None


def test_a_corner_that_sweeps_round_is_met() -> None:
    seen = outlook(SQUARE, Twist(0.0, 0.0, math.pi / 4), np.array([[0.0, 0.4]]))
    assert seen is not None
    assert seen.contact_s == pytest.approx(0.8, abs=0.25)


def test_a_body_that_stands_has_no_outline() -> None:
    assert outlook(SQUARE, Twist(0.0, 0.0, 0.0), NOTHING) is None
    assert outlook(np.zeros((0, 2)), Twist(0.0, 0.4, 0.0), NOTHING) is None
