"""From maps, zones and paths to what lies on the scene's floor: pure functions on arrays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.polyline import thinned_path
from app.console.grids import known_part
from app.messages import OccupancyGrid, Zone

#: More pixels on a side than this, and a picture is made coarser.
MOST_PIXELS = 1024
KEEP_OUT = (235, 70, 60)
SLOW = (245, 185, 60)
#: How high rails around zones are (m): the one keeps the robot out, the other does not.
RAIL_M = {"keep_out": 0.5, "slow": 0.12}
PATH_WIDTH_M = 0.07
#: Zones are tinted this far around the map (m).
MARGIN_M = 10.0
_PIXEL_M = 0.05
_BAR_M = 0.04
_TINT = 0.45
_TINT_OPACITY = 150
#: OpenCV takes corners in fractions of pixels.
_SHIFT = 4
_SUBPIXELS = 1 << _SHIFT


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """A picture on the floor: ``rgba`` (H, W, 4) uint8, its top row at the greatest y; ``center`` and ``size`` (m)."""

    rgba: NDArray[np.uint8]
    center: tuple[float, float]
    size: tuple[float, float]


def _palette(stops: list[tuple[int, tuple[int, int, int, int]]]) -> NDArray[np.uint8]:
    """Colours (256, 4) of cells 0 to 100, between ``stops``; nothing is drawn of unknown ones."""
    values = np.arange(101)
    at = [value for value, _ in stops]
    palette = np.zeros((256, 4), np.uint8)
    for band in range(4):
        palette[:101, band] = np.interp(values, at, [color[band] for _, color in stops]).round()
    return palette


#: Free space is dark, obstacles are bright.
MAP_COLORS = _palette([(0, (66, 88, 116, 130)), (50, (110, 132, 160, 160)), (100, (238, 243, 250, 240))])
#: Of the costmap only what costs something is drawn.
COST_COLORS = _palette([(0, (60, 120, 200, 0)), (99, (250, 150, 50, 255)), (100, (230, 50, 70, 255))])


def floor_layer(grid: OccupancyGrid | None, zones: Iterable[Zone] = ()) -> Layer | None:
    """The known part of ``grid`` (a map), with ``zones`` tinted over it; None where there is neither.

    All in one picture, since of two that lie over each other a viewer may draw the lower one last, or not at all. Zones
    count as far as :data:`MARGIN_M` around the map.
    """
    zones = tuple(zones)
    part = None if grid is None else known_part(grid)
    rectangle = _rectangle(part, zones)
    if rectangle is None:
        return None
    low, high = rectangle
    pixel_m = _PIXEL_M if part is None else part.resolution_m
    pixel_m *= max(1, int(np.ceil(float((high - low).max()) / pixel_m / MOST_PIXELS)))
    width, height = (max(1, round(float(side) / pixel_m)) for side in high - low)
    cells = np.full((height, width), -1, np.int8)
    if part is not None:
        _put(cells, part, low, pixel_m)
    # As whole words: a tenth of the time that four bytes by themselves take.
    rgba = MAP_COLORS.view(np.uint32)[:, 0].take(cells.view(np.uint8)).view(np.uint8).reshape(height, width, 4)
    marks = np.zeros((height, width), np.uint8)
    # Those that keep out lie over those that slow.
    for zone in sorted(zones, key=lambda zone: zone.kind == "keep_out"):
        corners = np.round(((zone.polygon - low) / pixel_m - 0.5) * _SUBPIXELS).astype(np.int32)
        cv2.fillPoly(marks, [corners], 2 if zone.kind == "keep_out" else 1, shift=_SHIFT)
    for mark, color in ((1, SLOW), (2, KEEP_OUT)):
        if (inside := marks == mark).any():
            rgba[inside] = _tinted(rgba[inside], color)
    size = (width * pixel_m, height * pixel_m)
    center = (float(low[0]) + 0.5 * size[0], float(low[1]) + 0.5 * size[1])
    return Layer(np.ascontiguousarray(rgba[::-1]), center, size)


def _rectangle(
    part: OccupancyGrid | None, zones: tuple[Zone, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Least and greatest x, y (m) of what is to be seen."""
    corners = [zone.polygon for zone in zones]
    if part is None:
        if not corners:
            return None
        every = np.concatenate(corners)
        return every.min(axis=0), every.max(axis=0)
    low = np.array(part.origin)
    high = low + part.resolution_m * np.array(part.cells.shape[::-1])
    if not corners:
        return low, high
    # On whole cells of the map, which lies in the picture as it is.
    every = np.clip(np.concatenate(corners), low - MARGIN_M, high + MARGIN_M)
    cell = part.resolution_m
    before = np.ceil(np.maximum(low - every.min(axis=0), 0) / cell) * cell
    return low - before, np.maximum(high, every.max(axis=0))


def _put(cells: NDArray[np.int8], part: OccupancyGrid, low: NDArray[np.float64], pixel_m: float) -> None:
    """Lay ``part`` into ``cells``, whose corner is ``low``; of several in a pixel the most occupied is shown, since
    walls are thinner than such a pixel."""
    times = round(pixel_m / part.resolution_m)
    left, bottom = (round(float(side) / part.resolution_m) for side in np.array(part.origin) - low)
    height, width = part.cells.shape
    fine = cells if times == 1 else np.full((cells.shape[0] * times, cells.shape[1] * times), -1, np.int8)
    room = fine[bottom : bottom + height, left : left + width]
    room[:] = part.cells[: room.shape[0], : room.shape[1]]
    if times > 1:
        cells[:] = np.maximum.reduce(
            [fine[row::times, column::times] for row in range(times) for column in range(times)]
        )


def _tinted(rgba: NDArray[np.uint8], color: tuple[int, int, int]) -> NDArray[np.uint8]:
    """``rgba`` (N, 4) with ``color`` over it."""
    tinted = rgba.astype(np.float32)
    tinted[..., :3] += _TINT * (np.array(color, np.float32) - tinted[..., :3])
    tinted[..., 3] = np.maximum(tinted[..., 3], _TINT_OPACITY)
    # Where there is nothing below, there is the colour alone.
    tinted[rgba[..., 3] == 0, :3] = color
    return tinted.astype(np.uint8)


def cost_points(grid: OccupancyGrid) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """The cells of a costmap that cost something: their middles (N, 3), m in its frame, and colours (N, 3)."""
    rows, columns = np.nonzero(grid.cells > 0)
    points = np.zeros((len(rows), 3), np.float32)
    points[:, 0] = grid.origin[0] + (columns + 0.5) * grid.resolution_m
    points[:, 1] = grid.origin[1] + (rows + 0.5) * grid.resolution_m
    return points, COST_COLORS[grid.cells[rows, columns].view(np.uint8), :3]


def rails(zones: Iterable[Zone], kind: str) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Rails on posts around the zones of ``kind``: vertices (V, 3), m on the map, and faces (F, 3)."""
    top = RAIL_M[kind]
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0

    def add(points: NDArray[np.float64], low: float, high: float) -> None:
        nonlocal count
        heights = np.ones(len(points))
        band, around = _strip(np.column_stack([points, low * heights]), np.column_stack([points, high * heights]))
        vertices.append(band)
        faces.append(around + count)
        count += len(band)

    for zone in zones:
        if zone.kind == kind:
            add(np.concatenate([zone.polygon, zone.polygon[:1]]), top - _BAR_M, top)
            for corner in zone.polygon:
                for across in ((0.5 * _BAR_M, 0.0), (0.0, 0.5 * _BAR_M)):
                    add(np.stack([corner - across, corner + across]), 0.0, top)
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32)


def ribbon(points: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """A path (N, 2) as a ribbon on the floor: vertices (V, 3) in the path's frame, and faces (F, 3)."""
    points = thinned_path(points)
    if len(points) > 1:
        # A repeated point has no direction.
        points = points[np.concatenate([[True], np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-6])]
    if len(points) < 2:
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)
    along = np.gradient(points, axis=0)
    # Where it turns back on itself, across is as it was before.
    lengths = np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    across = 0.5 * PATH_WIDTH_M * np.column_stack([-along[:, 1], along[:, 0]]) / lengths
    height = np.zeros(len(points))
    vertices, faces = _strip(np.column_stack([points - across, height]), np.column_stack([points + across, height]))
    return vertices.astype(np.float32), faces.astype(np.uint32)


def _strip(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Two triangles between every two neighbours of two lines (N, 3)."""
    count = len(one)
    first = np.arange(count - 1)
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + count], axis=1),
            np.stack([first + 1, first + 1 + count, first + count], axis=1),
        ]
    )
    return np.concatenate([one, other]), faces
