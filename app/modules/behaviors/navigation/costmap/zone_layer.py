"""Zones of the map: keep-out zones and slow zones."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import Zone
from app.modules.behaviors.navigation.costmap.grid import GridFrame

#: Sub-cell precision of OpenCV's drawing, as a power of two, and the drawn margin beyond the grid, in cells.
_SHIFT = 6
_FAR = 1e6


def rasterize(zones: Sequence[Zone], frame: GridFrame) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """The zones on a grid of the map: keep-out (H, W) uint8, 1 where a zone touches a cell, and the share of the
    greatest speed allowed (H, W) float32, 1 outside of slow zones, the least where they overlap."""
    shut = np.zeros((frame.rows, frame.columns), dtype=np.uint8)
    share = np.ones((frame.rows, frame.columns), dtype=np.float32)
    # The slowest zone is drawn last and overwrites the others.
    for zone in sorted(zones, key=lambda zone: -zone.speed):
        cells = (zone.polygon - np.array([frame.x, frame.y])) / frame.resolution_m - 0.5
        corners = np.rint(np.clip(cells, -_FAR, _FAR) * 2**_SHIFT).astype(np.int32)[None]
        if zone.kind == "keep_out":
            cv2.fillPoly(shut, [corners], 1, shift=_SHIFT)
            _shut_edges(shut, cells)
        else:
            cv2.fillPoly(share, [corners], zone.speed, shift=_SHIFT)
    return shut, share


def _shut_edges(shut: NDArray[np.uint8], corners: NDArray[np.float64]) -> None:
    """Close every cell that the polygon's edges pass: a thin zone must not leak.

    ``corners`` (N, 2) column, row. OpenCV's own lines break outside the grid.
    """
    last = np.array([shut.shape[1], shut.shape[0]], dtype=np.float64)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        begin, end = _within(a, b - a, last)
        if begin <= end:
            steps = math.ceil(4.0 * (end - begin) * float(np.abs(b - a).max())) + 1
            cells = np.rint(a + np.linspace(begin, end, steps)[:, None] * (b - a)).astype(np.int64)
            columns, rows = cells[((cells >= 0) & (cells < last)).all(axis=1)].T
            shut[rows, columns] = 1


def _within(a: NDArray[np.float64], along: NDArray[np.float64], last: NDArray[np.float64]) -> tuple[float, float]:
    """The part [begin, end], of 0 to 1, of the segment from ``a`` between (-1, -1) and ``last``; begin > end: none."""
    still = along == 0.0
    if bool((still & ((a < -1.0) | (a > last))).any()):
        return 1.0, 0.0
    step = np.where(still, 1.0, along)
    one, other = (-1.0 - a) / step, (last - a) / step
    enters = np.where(still, 0.0, np.minimum(one, other))
    leaves = np.where(still, 1.0, np.maximum(one, other))
    return max(0.0, float(enters.max())), min(1.0, float(leaves.min()))


def speed_share(zones: Sequence[Zone], x: float, y: float, margin_m: float = 0.0) -> tuple[float, str]:
    """The share of the greatest speed allowed at a place on the map, in ]0, 1], and the name of the limiting zone.

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
    """Depth (m) of the place inside the zone; negative: distance outside."""
    # Relative to the place, so that 32 bits are enough far from the map's origin.
    polygon = (zone.polygon - np.array([x, y])).astype(np.float32)[:, None]
    return float(cv2.pointPolygonTest(polygon, (0.0, 0.0), measureDist=True))
