"""Walls from a map: every occupied cell is in one box, and no other is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.view.walls import HEIGHT_M, rectangles, wall_boxes
from tests.console.places import grid


@given(st.lists(st.lists(st.booleans(), min_size=7, max_size=7), min_size=1, max_size=9))
def test_rectangles_cover_each_occupied_cell_once(rows: list[list[bool]]) -> None:
    occupied = np.array(rows)
    covered = np.zeros(occupied.shape, int)
    for row, column, end_row, end_column in rectangles(occupied):
        covered[row:end_row, column:end_column] += 1
    assert (covered == occupied).all()


def test_a_straight_wall_is_one_box_where_it_is_on_the_map() -> None:
    occupied = np.zeros((6, 8), np.bool_)
    occupied[1:5, 3] = True
    assert rectangles(occupied).tolist() == [[1, 3, 5, 4]]


def test_boxes_lie_where_the_cells_are_and_all_faces_are_of_them() -> None:
    known = grid(1.0)  # one wall cell: the 5th of the 10th row
    vertices, faces = wall_boxes(known)
    (left, bottom), cell = known.origin, known.resolution_m
    assert vertices.min(axis=0) == pytest.approx((left + 5 * cell, bottom + 10 * cell, 0.0), abs=1e-5)
    assert vertices.max(axis=0) == pytest.approx((left + 6 * cell, bottom + 11 * cell, HEIGHT_M), abs=1e-5)
    assert faces.max() == len(vertices) - 1
    # Each face looks away from the box's middle.
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    assert ((np.cross(b - a, c - a) * ((a + b + c) / 3 - middle)).sum(axis=1) > 0).all()


def test_without_a_map_there_are_no_walls() -> None:
    vertices, faces = wall_boxes(None)
    assert (len(vertices), len(faces)) == (0, 0)
