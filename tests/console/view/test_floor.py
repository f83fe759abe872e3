"""From maps, zones and paths to what lies on the floor."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.console.view.floor import MOST_PIXELS, Layer, cost_points, floor_layer, rails, ribbon
from app.console.view.ground import COSTMAP_PERIOD_S, MAP_PERIOD_S, layer_period_s
from app.messages import OccupancyGrid, Zone
from tests.console.places import grid, zone


def color_at(layer: Layer, x: float, y: float) -> tuple[int, ...]:
    """The colour of the floor at (x, y), m on the map."""
    height, width, _ = layer.rgba.shape
    column = (x - layer.center[0]) / layer.size[0] * width + 0.5 * width
    row = 0.5 * height - (y - layer.center[1]) / layer.size[1] * height
    return tuple(int(value) for value in layer.rgba[int(row), int(column)])


@given(
    st.integers(1, 60),
    st.integers(1, 60),
    st.integers(-400, 400),
    st.data(),
)
@settings(max_examples=25, deadline=None)
def test_every_cell_lies_where_it_is(height: int, width: int, offset: int, data: st.DataObject) -> None:
    row, column = data.draw(st.integers(0, height - 1)), data.draw(st.integers(0, width - 1))
    cells = np.zeros((height, width), np.int8)
    cells[row, column] = 100
    whole = OccupancyGrid(1.0, "map", cells, 0.05, (0.05 * offset, -1.0), 1)
    x, y = 0.05 * (offset + column + 0.5), -1.0 + 0.05 * (row + 0.5)
    zones = (zone(),) if data.draw(st.booleans()) else ()
    layer = floor_layer(whole, zones)
    assert layer is not None
    found = np.argwhere(layer.rgba[..., 3] == 240)
    assert len(found) == 1
    assert color_at(layer, x, y)[3] == 240


def test_of_a_large_map_no_wall_is_lost() -> None:
    cells = np.zeros((900, 3000), np.int8)
    cells[:, 1501] = 100
    cells[0, 0] = -1
    layer = floor_layer(OccupancyGrid(1.0, "map", cells, 0.05, (-75.0, 0.0), 1))
    assert layer is not None
    assert max(layer.rgba.shape) <= MOST_PIXELS
    for y in (0.2, 20.0, 44.9):
        assert color_at(layer, -75.0 + 0.05 * 1501.5, y)[3] == 240
        assert color_at(layer, 20.0, y)[3] == 130


def test_unknown_floor_is_not_drawn_but_for_zones() -> None:
    plain, tinted = floor_layer(grid(1.0)), floor_layer(grid(1.0), (zone(), zone("slowly", "slow", 0.5)))
    assert plain is not None
    assert tinted is not None
    known = (0.3, -1.0)
    assert color_at(plain, *known) == color_at(tinted, *known) == (66, 88, 116, 130)
    # The triangle (0, 0), (2, 0), (2, 1): one that keeps out lies over one that slows.
    red, green, _, alpha = color_at(tinted, 1.8, 0.5)
    assert red > 2 * green
    assert alpha >= 130
    assert color_at(tinted, 0.4, 0.8)[3] == 0
    assert floor_layer(None) is None
    only = floor_layer(None, (zone(),))
    assert only is not None
    assert only.center == pytest.approx((1.0, 0.5), abs=0.05)
    far = Zone("far", "slow", np.array([[500.0, 0.0], [900.0, 0.0], [900.0, 900.0]]), 0.5)
    bounded = floor_layer(grid(1.0), (far,))
    assert bounded is not None
    assert max(bounded.size) < 25


def test_rails_stand_around_zones_of_their_kind() -> None:
    vertices, faces = rails((zone(), zone("b", "slow")), "keep_out")
    assert faces.max() == len(vertices) - 1
    assert vertices[:, 2].max() == pytest.approx(0.5)
    np.testing.assert_allclose(vertices[:, :2].min(axis=0), (0, 0), atol=0.03)
    np.testing.assert_allclose(vertices[:, :2].max(axis=0), (2, 1), atol=0.03)
    assert rails((), "slow")[1].shape == (0, 3)


def test_a_path_is_a_ribbon_of_one_width() -> None:
    angles = np.linspace(0, math.pi, 500)
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    vertices, faces = ribbon(points)
    half = len(vertices) // 2
    np.testing.assert_allclose(np.linalg.norm(vertices[:half] - vertices[half:], axis=1), 0.07, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(vertices[:, :2], axis=1), 1.0, atol=0.036)
    assert len(faces) == 2 * (half - 1)
    for nothing in (np.zeros((0, 2)), np.ones((1, 2)), np.ones((5, 2))):
        assert len(ribbon(nothing)[1]) == 0


def test_what_costs_something_is_a_point() -> None:
    points, colors = cost_points(grid(1.0, frame="odom"))
    np.testing.assert_allclose(points, [[-1.0 + 5.5 * 0.05, -2.0 + 10.5 * 0.05, 0.0]], rtol=1e-6)
    assert colors.tolist() == [[230, 50, 70]]


def test_layers_are_sent_seldom_where_drawing_takes_long() -> None:
    assert layer_period_s(MAP_PERIOD_S, 0.04) == MAP_PERIOD_S >= 2.0
    assert layer_period_s(COSTMAP_PERIOD_S, 0.04) == COSTMAP_PERIOD_S
    assert layer_period_s(MAP_PERIOD_S, 1.0) == 10.0
