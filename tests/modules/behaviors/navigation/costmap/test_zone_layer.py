from __future__ import annotations

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from app.modules.behaviors.navigation.costmap.grid import GridFrame
from app.modules.behaviors.navigation.costmap.zone_layer import keep_out, rasterize, speed_share
from tests.modules.behaviors.navigation.maps import box, zone

FRAME = GridFrame(-1.0, -1.0, 0.05, 60, 80)
SHUT = zone("keep_out", box(0.0, 0.0, 1.0, 0.5), name="Stairs")
SLOW = zone("slow", box(0.5, -0.5, 2.0, 1.0), 0.3, name="Nursery")
SLOWER = zone("slow", box(1.5, -0.5, 2.5, 1.0), 0.1, name="Glass")


def test_cells_in_a_zone() -> None:
    shut, share = rasterize((SHUT, SLOW, SLOWER), FRAME)
    for row in range(0, 60, 3):
        for column in range(0, 80, 3):
            x, y = FRAME.middle(row, column)
            if 0.06 < x < 0.94 and 0.06 < y < 0.44:
                assert shut[row, column] == 1
            if not (-0.06 < x < 1.06 and -0.06 < y < 0.56):
                assert shut[row, column] == 0
            if all(abs(x - edge) > 0.06 for edge in (0.5, 1.5, 2.0, 2.5)) and all(
                abs(y - e) > 0.06 for e in (-0.5, 1.0)
            ):
                assert share[row, column] == np.float32(speed_share((SLOW, SLOWER), x, y)[0])


@example(0.0, 1.96875, 1.0, 0.25, 0.0078125)  # leaves the grid at a flat angle
@given(st.floats(-3, 5), st.floats(-3, 5), st.floats(0.02, 6), st.floats(0, 2 * math.pi), st.floats(1e-4, 0.01))
def test_a_keep_out_zone_as_thin_as_a_hair_is_shut_all_along(
    x: float, y: float, length: float, angle: float, width: float
) -> None:
    ahead, left = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    begin = np.array([x, y])
    corners = (begin, begin + length * ahead, begin + length * ahead + width * left, begin + width * left)
    hair = zone("keep_out", [(float(at[0]), float(at[1])) for at in corners])
    shut, _ = rasterize((hair,), FRAME)
    points = begin + np.linspace(0, length, 50)[:, None] * ahead
    cells, inside = FRAME.cells(points)
    padded = np.pad(shut, 1)
    for row, column in cells[inside]:
        assert padded[row : row + 3, column : column + 3].any()


def test_the_slowest_zone_near_a_place_says_how_fast() -> None:
    zones = (SHUT, SLOW, SLOWER)
    assert speed_share(zones, 1.0, 0.8) == (0.3, "Nursery")
    assert speed_share(zones, 1.7, 0.0) == (0.1, "Glass")
    assert speed_share(zones, 3.0, 0.0) == (1.0, "")
    assert speed_share(zones, 2.9, 0.0, margin_m=0.5) == (0.1, "Glass")


def test_which_zone_keeps_out() -> None:
    assert keep_out((SHUT, SLOW), 0.5, 0.25) == "Stairs"
    assert keep_out((SHUT, SLOW), 1.2, 0.25) is None
    assert keep_out((SHUT, SLOW), 1.2, 0.25, margin_m=0.3) == "Stairs"


def test_zones_beyond_the_grid_are_not_on_it() -> None:
    shut, share = rasterize((zone("keep_out", box(1e5, 1e5, 1e9, 1e9)), zone("slow", box(-1e9, 50, 1e9, 1e9))), FRAME)
    assert not shut.any()
    assert (share == 1.0).all()
