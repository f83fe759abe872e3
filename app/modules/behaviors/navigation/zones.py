"""Zones of the map: what the robot keeps out of, and where it goes slowly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.messages import Zone
from app.modules.behaviors.navigation.grid import GridFrame


def rasterize(zones: Sequence[Zone], frame: GridFrame) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """The zones on a grid of the map: keep-out (H, W) uint8, 1 where a cell is touched, and the share of the greatest
    speed allowed (H, W) float32, 1 outside of slow zones, the least where they overlap."""
    raise NotImplementedError


def speed_share(zones: Sequence[Zone], x: float, y: float, margin_m: float = 0.0) -> tuple[float, str]:
    """The share of the greatest speed allowed at a place on the map, in ]0, 1], and the name of the zone that says so.

    The least of all slow zones within ``margin_m`` of the place; 1.0 and "" outside of them.
    """
    raise NotImplementedError


def keep_out(zones: Sequence[Zone], x: float, y: float, margin_m: float = 0.0) -> str | None:
    """The name of a keep-out zone within ``margin_m`` of the place (m on the map), None if there is none."""
    raise NotImplementedError
