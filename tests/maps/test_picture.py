"""A map as a picture."""

from __future__ import annotations

import cv2
import numpy as np

from app.maps.picture import UNKNOWN, shown_png, values_png
from app.messages import OccupancyGrid

GRID = OccupancyGrid(0.0, "map", np.array([[0, 50, 100], [-1, -1, 7]], np.int8), 0.05, (0.0, 0.0), 1)


def pixels(png: bytes) -> list[list[int]]:
    shown = np.asarray(cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED))
    return shown.tolist()


def test_values_are_the_cells_own_the_furthest_north_on_top() -> None:
    assert pixels(values_png(GRID)) == [[UNKNOWN, UNKNOWN, 7], [0, 50, 100]]


def test_people_see_free_white_occupied_black_and_unknown_grey() -> None:
    assert pixels(shown_png(GRID)) == [[205, 205, 236], [254, 127, 0]]
