"""Cost per metre on the map: obstacles inflated by the footprint, zones, unknown space.

Only changed parts of the map are computed again (``previous``). Obstacles that are not on the map are overlaid
(:func:`with_obstacles`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.grid import GridFrame
from app.modules.behaviors.navigation.costmap.zone_layer import rasterize

#: Kinds of a cell, and of the obstacles it is too near to (bits of :attr:`CostField.layers`).
OCCUPIED, KEEP_OUT, TEMPORARY, UNKNOWN, AT_OCCUPIED, AT_KEEP_OUT, AT_TEMPORARY = (1 << bit for bit in range(7))

#: Side of the squares (cells) in which changes are detected and recomputed.
_TILE = 64
#: Distance (cells) greater than any on a map.
_VERY_FAR = np.float32(1e6)
#: Side of the square (cells) whose majority decides whether a cell is unknown.
_AROUND = (5, 5)


@dataclass(frozen=True, slots=True)
class CostSettings:
    """Parameters of the costs. A metre of open floor costs 1, in a slow zone 1 / its share of speed (the time it
    takes).

    Cells nearer to an obstacle than the inscribed radius are lethal. At that radius a metre costs ``closeness`` more;
    the surcharge falls quadratically to zero at ``reach_m`` beyond the circumscribed radius, so that paths keep to the
    middle of corridors narrower than twice that. ``unknown`` space (most cells around are unknown) is ``free``,
    ``costly`` (``unknown_cost`` more per metre, a last resort) or ``blocked``.

    Cells of at least ``occupied_from`` (0 to 100) are obstacles.
    """

    reach_m: float = 0.75
    closeness: float = 6.0
    unknown: str = "costly"
    unknown_cost: float = 10.0
    occupied_from: int = 65


@dataclass(frozen=True, slots=True, eq=False)
class CostField:
    """Cost per metre on the map. The arrays are read-only.

    ``layers`` (H, W) uint8: kind of each cell, and which obstacles, zones or transient obstacles are nearer than
    ``lethal_m``. ``clearance`` (H, W) float32: m from its middle to that of the nearest obstacle (or keep-out
    zone), at most ``reach_m`` beyond the circumscribed radius. ``cost`` (H, W) float32: of a metre, >= 1, +inf where
    the body's middle may not be (lethal). ``known``: the field without transient obstacles, None if it is this one.
    """

    frame: GridFrame
    layers: NDArray[np.uint8]
    clearance: NDArray[np.float32]
    cost: NDArray[np.float32]
    footprint: Footprint
    settings: CostSettings
    zones: tuple[Zone, ...]
    zone_clearance: NDArray[np.float32] | None
    share: NDArray[np.float32] | None
    known: CostField | None = None

    @property
    def reach_m(self) -> float:
        """Clearance from which on there is no surcharge."""
        return self.footprint.circumscribed_m + self.settings.reach_m

    @property
    def lethal_m(self) -> float:
        """Clearance below which a cell is lethal."""
        # A little over one cell at least: no path passes a wall between two cells that touch by their corners.
        return max(self.footprint.passing_m, 1.01 * self.frame.resolution_m)


def cost_field(
    grid: OccupancyGrid,
    footprint: Footprint,
    zones: tuple[Zone, ...] = (),
    settings: CostSettings | None = None,
    previous: CostField | None = None,
) -> CostField:
    """The field of a map and its zones. ``previous``: the field of an earlier version of the same map, to compute only
    the changes; the result is the same without it."""
    settings = settings or CostSettings()
    frame = GridFrame.of(grid)
    old = (previous.known or previous) if previous is not None else None
    if old is not None and not (old.frame == frame and old.settings == settings and old.footprint is footprint):
        old = None
    layers = _layers(grid, settings)
    zone_clearance, share = None, None
    if old is not None and (old.zones == zones):
        zone_clearance, share = old.zone_clearance, old.share
        layers |= old.layers & np.uint8(KEEP_OUT)
    else:
        if zones:
            shut, share = rasterize(zones, frame)
            zone_clearance = _distances(shut == 0, frame.resolution_m)
            layers |= shut * np.uint8(KEEP_OUT)
        old = None
    if old is None:
        clearance, cost = np.empty(layers.shape, dtype=np.float32), np.empty(layers.shape, dtype=np.float32)
        field = CostField(
            frame,
            layers,
            clearance=clearance,
            cost=cost,
            footprint=footprint,
            settings=settings,
            zones=zones,
            zone_clearance=zone_clearance,
            share=share,
        )
        _fill(field, (slice(0, frame.rows), slice(0, frame.columns)))
        return field
    itself = np.uint8(OCCUPIED | UNKNOWN)
    boxes = list(_boxes((layers & itself) != (old.layers & itself), _reach_cells(old)))
    if not boxes:
        return old
    layers |= old.layers & np.uint8(AT_OCCUPIED | AT_KEEP_OUT)
    field = replace(old, layers=layers, clearance=old.clearance.copy(), cost=old.cost.copy())
    for box in boxes:
        _fill(field, box)
    return field


def with_obstacles(field: CostField, points: NDArray[np.float64]) -> CostField:
    """``field`` with obstacles at ``points`` (N, 2), m on the map, that the map does not have; they replace earlier
    ones."""
    from app.modules.behaviors.navigation.costmap.cost_kernels import overlay

    known = field.known or field
    cells, inside = known.frame.cells(points)
    rows, columns = cells[inside].T
    if not len(rows):
        return known
    there = np.zeros(known.layers.shape, dtype=np.uint8)
    there[rows, columns] = 1
    layers = known.layers | there * np.uint8(TEMPORARY)
    result = replace(known, layers=layers, clearance=known.clearance.copy(), cost=known.cost.copy(), known=known)
    reach = _reach_cells(known)
    for box in _boxes(there, reach):
        around, inner = _widened(box, reach, there.shape)
        distances = _distances(there[around] == 0, known.frame.resolution_m)[inner]
        share = known.share[box] if known.share is not None else _NONE
        overlay(distances, share, result.layers[box], result.clearance[box], result.cost[box], *_prices(known))
    return result


_Box = tuple[slice, slice]
_NONE = np.empty((0, 0), dtype=np.float32)


def _layers(grid: OccupancyGrid, settings: CostSettings) -> NDArray[np.uint8]:
    values = np.arange(256, dtype=np.uint8).view(np.int8)
    what = np.zeros(256, dtype=np.uint8)
    what[values >= settings.occupied_from] = OCCUPIED
    what[values < 0] = UNKNOWN
    layers = np.asarray(cv2.LUT(np.ascontiguousarray(grid.cells).view(np.uint8), what), dtype=np.uint8)
    # Rays miss single cells, and single rays reach beyond a window: the majority of the cells around counts.
    marked = (layers & np.uint8(UNKNOWN)) * np.uint8(255 // UNKNOWN)
    unknown = cv2.blur(marked, _AROUND, borderType=cv2.BORDER_REPLICATE)
    layers &= np.uint8(OCCUPIED)
    layers |= ((unknown > 127) & (layers == 0)) * np.uint8(UNKNOWN)
    return layers


def _fill(field: CostField, box: _Box) -> None:
    from app.modules.behaviors.navigation.costmap.cost_kernels import lay

    around, inner = _widened(box, _reach_cells(field), field.layers.shape)
    distances = _distances((field.layers[around] & OCCUPIED) == 0, field.frame.resolution_m)[inner]
    zone = field.zone_clearance[box] if field.zone_clearance is not None else _NONE
    share = field.share[box] if field.share is not None else _NONE
    lay(distances, zone, share, field.layers[box], field.clearance[box], field.cost[box], *_prices(field))


def _prices(field: CostField) -> tuple[float, float, float, float]:
    """Arguments of the kernels in ``cost_kernels``: lethal and reach (m), closeness, unknown."""
    unknown = {"free": 0.0, "costly": field.settings.unknown_cost, "blocked": math.inf}[field.settings.unknown]
    return field.lethal_m, field.reach_m, field.settings.closeness, unknown


def _distances(free: NDArray[np.bool_], resolution_m: float) -> NDArray[np.float32]:
    """m from each cell's middle to that of the nearest cell that is not free; very large where all are free."""
    distances = np.asarray(cv2.distanceTransform(free.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))
    # Squared distances between cells are whole numbers. The last bit of OpenCV's roots depends on how its threads share
    # the rows, and the choice between two equal paths would depend on it.
    np.minimum(distances, _VERY_FAR, out=distances)
    np.sqrt(np.rint(np.square(distances, out=distances), out=distances), out=distances)
    return np.asarray(distances * np.float32(resolution_m), dtype=np.float32)


def _reach_cells(field: CostField) -> int:
    return math.ceil(field.reach_m / field.frame.resolution_m) + 1


def _boxes(changed: NDArray[np.generic], reach: int) -> Iterator[_Box]:
    """Boxes that together contain all cells within ``reach`` of a changed one, with little overlap."""
    rows, columns = changed.shape
    rows_at, columns_at = np.arange(0, rows, _TILE), np.arange(0, columns, _TILE)
    tiles = np.logical_or.reduceat(np.logical_or.reduceat(changed, rows_at, axis=0), columns_at, axis=1)
    if not tiles.any():
        return
    side = 2 * math.ceil(reach / _TILE) + 1
    count, _, boxes, _ = cv2.connectedComponentsWithStats(
        cv2.dilate(tiles.view(np.uint8), np.ones((side, side), np.uint8))
    )
    for column, row, width, height, _ in boxes[1:count].tolist():
        yield (
            slice(row * _TILE, min((row + height) * _TILE, rows)),
            slice(column * _TILE, min((column + width) * _TILE, columns)),
        )


def _widened(box: _Box, reach: int, shape: tuple[int, ...]) -> tuple[_Box, _Box]:
    """The box with a margin of ``reach`` within the array, and the box's own place in it."""
    around, inner = [], []
    for side, length in zip(box, shape, strict=True):
        begin, end = max(side.start - reach, 0), min(side.stop + reach, length)
        around.append(slice(begin, end))
        inner.append(slice(side.start - begin, side.stop - begin))
    return (around[0], around[1]), (inner[0], inner[1])
