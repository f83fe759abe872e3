"""The grid of directions: where cells are, and that it turns."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import azimuth_elevation
from app.modules.perception.saliency.sphere_grid import SphereGrid

GRID = SphereGrid()


def test_cells_go_from_the_left_behind_to_the_right_behind_and_from_the_top_down() -> None:
    assert (GRID.rows, GRID.columns) == (32, 120)
    directions = GRID.directions()
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1)
    first, last = azimuth_elevation(directions[0, 0]), azimuth_elevation(directions[-1, -1])
    assert np.degrees(first) == pytest.approx((178.5, 46.5))
    assert np.degrees(last) == pytest.approx((-178.5, -46.5))
    assert (GRID.finer(2).rows, GRID.finer(2).columns) == (64, 240)


def test_cells_that_do_not_go_around_are_refused() -> None:
    with pytest.raises(ValueError, match="7° do not fit"):
        SphereGrid(math.radians(7))


@given(st.integers(0, 119), st.integers(-300, 300))
def test_turned_axes_have_a_cell_where_its_direction_is(column: int, steps: int) -> None:
    heading = steps * GRID.step_rad
    values = np.zeros((GRID.rows, GRID.columns), np.float32)
    values[16, column] = 1.0
    row, found = divmod(int(np.argmax(GRID.turned(values, heading))), GRID.columns)
    off = GRID.azimuths[found] - (GRID.azimuths[column] - heading)
    assert row == 16
    assert math.cos(off) == pytest.approx(1.0)
