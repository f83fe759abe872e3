"""A room as a map: 6 m by 4 m, its walls one cell thick, a pillar in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.maps.library import MapLibrary
from app.messages import OccupancyGrid

CELL_M = 0.05


def room() -> OccupancyGrid:
    """Inner walls at x = -0.95 and 4.95, y = -1.95 and 1.95 (m); a pillar of 0.4 m about (3.0, 0.0)."""
    cells = np.zeros((80, 120), np.int8)
    cells[0], cells[-1], cells[:, 0], cells[:, -1] = 100, 100, 100, 100
    cells[36:44, 76:84] = 100
    return OccupancyGrid(0.0, "map", cells, CELL_M, origin=(-1.0, -2.0), version=1)


def kept(folder: Path, name: str = "room") -> Path:
    """The room as a kept map in the library ``folder``; returns its YAML file."""
    MapLibrary(folder).keep(name, room())
    return folder / name / "map.yaml"
