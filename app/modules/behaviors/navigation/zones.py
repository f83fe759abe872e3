"""Zones of the map: what the robot keeps out of, and where it goes slowly."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import Zone
from app.modules.behaviors.navigation.grid import GridFrame

#: Fractions of a cell that OpenCV draws by, as a power of two, and how far beyond the grid it is let draw, in cells.
_SHIFT = 6
_FAR = 1e6


def rasterize(zones: Sequence[Zone], frame: GridFrame) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """The zones on a grid of the map: keep-out (H, W) uint8, 1 where a zone touches a cell, and the share of the
    greatest speed allowed (H, W) float32, 1 outside of slow zones, the least where they overlap."""
    shut = np.zeros((frame.rows, frame.columns), dtype=np.uint8)
    share = np.ones((frame.rows, frame.columns), dtype=np.float32)
    # The slowest is drawn last, and so is on top.
    for zone in sorted(zones, key=lambda zone: -zone.speed):
        cells = (zone.polygon - np.array([frame.x, frame.y])) / frame.resolution_m - 0.5
        corners = np.rint(np.clip(cells, -_FAR, _FAR) * 2**_SHIFT).astype(np.int32)[None]
        if zone.kind == "keep_out":
            cv2.fillPoly(shut, [corners], 1, shift=_SHIFT)
            # However thin it is, no way leads through.
            cv2.polylines(shut, [corners], isClosed=True, color=1, thickness=1, shift=_SHIFT)
        else:
            cv2.fillPoly(share, [corners], zone.speed, shift=_SHIFT)
    return shut, share


def speed_share(zones: Sequence[Zone], x: float, y: float, margin_m: float = 0.0) -> tuple[float, str]:
    """The share of the greatest speed allowed at a place on the map, in ]0, 1], and the name of the zone that says so.

    The least of all slow zones within ``margin_m`` of the place; 1.0 and "" outside of them.
    """
    near = [zone for zone in zones if zone.kind == "slow" and _inside_m(zone, x, y) >= -margin_m]
    if not near:
        return 1.0, ""
    slowest = min(near, key=lambda zone: zone.speed)
    return min(1.0, slowest.speed), slowest.name


def keep_out(zones: Sequence[Zone], x: float, y: float, margin_m: float = 0.0) -> str | None:
    """The name of a keep-out zone within ``margin_m`` of the place (m on the map), None if there is none."""
    for zone in zones:
        if zone.kind == "keep_out" and _inside_m(zone, x, y) >= -margin_m:
            return zone.name
    return None


def _inside_m(zone: Zone, x: float, y: float) -> float:
    """How deep (m) inside the zone the place is; negative: how far outside."""
    # About the place itself, so that 32 bits are enough for a map far from its frame's origin
    polygon = (zone.polygon - np.array([x, y])).astype(np.float32)[:, None]
    return float(cv2.pointPolygonTest(polygon, (0.0, 0.0), measureDist=True))
