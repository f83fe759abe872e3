"""Thinned paths."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.base.polyline import MOST_POINTS, thinned_path


@given(
    st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=600),
    st.sampled_from([0.05, 0.1]),
)
def test_a_thinned_path_goes_the_same_way(turns: list[float], step_m: float) -> None:
    """Both ends stay; every point left out is near the line that is drawn instead."""
    headings = np.cumsum(turns)
    steps = step_m * np.stack([np.cos(headings), np.sin(headings)], axis=1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    thin = thinned_path(points)
    assert len(thin) <= MOST_POINTS
    np.testing.assert_array_equal(thin[[0, -1]], points[[0, -1]])
    lines = np.diff(thin, axis=0)
    lengths = np.maximum(np.linalg.norm(lines, axis=1), 1e-9)
    along = np.einsum("psk,sk->ps", points[:, None] - thin[:-1], lines) / lengths**2
    nearest = thin[:-1] + np.clip(along, 0, 1)[..., None] * lines
    furthest = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1).max()
    assert furthest <= step_m * max(2.0, len(points) / MOST_POINTS)


def test_a_wide_bend_is_no_straight_line() -> None:
    angles = np.linspace(0, math.pi / 2, 2000)
    thin = thinned_path(50.0 * np.stack([np.sin(angles), 1 - np.cos(angles)], axis=1))
    assert 100 < len(thin) <= MOST_POINTS
