"""Outlines cover what they are of; groups are chains; wheels are told from arms by how joints follow each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base import paths
from app.base.kinematic_model import load_model
from app.robots.actuator_config import check_footprint
from app.robots.importing.groups import proposed_groups, wheels
from app.robots.importing.outline import around
from tests.robots.importing.models import write_urdf

ROBOTS = paths.config_dir() / "robots"
coordinates = st.floats(-2, 2, allow_nan=False)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=40))
def test_an_outline_is_a_footprint_that_covers_its_points(points: list[tuple[float, float]]) -> None:
    corners = around(np.array(points))
    if not corners:
        return
    assert len(corners) <= 16
    check_footprint(corners)
    following = (*corners[1:], corners[0])
    for (ax, ay), (bx, by) in zip(corners, following, strict=True):
        for x, y in points:
            assert (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= -5e-3


def test_what_does_not_lie_around_the_root_has_no_outline() -> None:
    assert around(np.array([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]])) == ()
    assert around(np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])) == ()


def test_wheels_turn_without_end_and_carry_no_arm(tmp_path: Path) -> None:
    assert wheels(load_model(write_urdf(tmp_path))) == {"left_wheel_joint"}
    assert wheels(load_model(ROBOTS / "irl1_tr.urdf")) >= {"left_wheel_joint", "right_wheel_joint"}


@pytest.mark.parametrize("name", ["irl1_tr", "jackal", "turtlebot4"])
def test_groups_have_every_joint_but_wheels_once(name: str) -> None:
    model = load_model(ROBOTS / f"{name}.urdf")
    grouped = [joint for group in proposed_groups(model).values() for joint in group]
    assert sorted(grouped) == sorted(set(model.joint_names) - wheels(model))
