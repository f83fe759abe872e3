"""Directions of a sweep, and when the next one's turn is."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.modules.behaviors.gaze.sweep import Sweep, directions


@given(st.floats(0, math.tau), st.floats(0.1, math.pi), st.lists(st.floats(-1, 1), min_size=1, max_size=3))
def test_directions_span_the_width_in_steps_and_each_row_goes_back(
    width: float, step: float, elevations: list[float]
) -> None:
    found = directions(width, step, elevations)
    rows = [found[i : i + len(found) // len(elevations)] for i in range(0, len(found), len(found) // len(elevations))]
    assert [row[0][1] for row in rows] == elevations
    bearings = [bearing for bearing, _ in rows[0]]
    assert bearings[-1] - bearings[0] == pytest.approx(width)
    assert all(0 <= b - a <= step + 1e-9 for a, b in itertools.pairwise(bearings))
    for before, after in itertools.pairwise(rows):
        assert after[0][0] == pytest.approx(before[-1][0]), "no swing between two rows"


def test_a_direction_is_left_only_after_a_pause_at_it() -> None:
    sweep = Sweep(((0.0, 0.0), (1.0, 0.0)), pause_s=1.0)
    assert sweep.step(0.0, reached=False) == (0.0, 0.0)
    assert sweep.step(5.0, reached=False) == (0.0, 0.0), "it is not there yet"
    assert sweep.step(6.0, reached=True) == (0.0, 0.0)
    assert sweep.step(6.9, reached=True) == (0.0, 0.0)
    assert sweep.step(7.0, reached=True) == (1.0, 0.0)
    assert (sweep.step(8.0, reached=True), sweep.round) == ((1.0, 0.0), 0)
    assert (sweep.step(9.0, reached=True), sweep.round) == ((0.0, 0.0), 1)
