"""What a metre of way costs everywhere on the map: obstacles inflated by the footprint, zones, unknown space.

The field is made anew only where its map changed (``previous``); what stands in the way but not on the map is laid over
it (:func:`with_obstacles`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.grid import GridFrame
from app.modules.behaviors.navigation.costmap.zone_layer import rasterize

#: What a cell is, and what it is too near to (bits of :attr:`CostField.layers`).
OCCUPIED, KEEP_OUT, TEMPORARY, UNKNOWN, AT_OCCUPIED, AT_KEEP_OUT, AT_TEMPORARY = (1 << bit for bit in range(7))

#: Changes are looked for, and mended, in squares of so many cells.
_TILE = 64
#: In cells: no map is as large.
_VERY_FAR = np.float32(1e6)
#: Cells are unknown where most in such a square are.
_AROUND = (5, 5)


@dataclass(frozen=True, slots=True)
class CostSettings:
    """What is dear. A metre in the open costs 1, in a slow zone 1 / its share of speed (the time it takes).

    Nearer to an obstacle than the inscribed radius no way leads; there a metre costs ``closeness`` more, and less and
    less (quadratically) to ``reach_m`` beyond the circumscribed radius: ways keep to the middle of corridors narrower
    than twice that. ``unknown`` space, where most cells around are unknown, is ``free``, ``costly`` (``unknown_cost``
    more a metre: a last resort) or ``blocked``.
    Cells of at least ``occupied_from`` (0 to 100) are obstacles.
    """

    reach_m: float = 0.75
    closeness: float = 6.0
    unknown: str = "costly"
    unknown_cost: float = 10.0
    occupied_from: int = 65


@dataclass(frozen=True, slots=True, eq=False)
class CostField:
    """What going costs on the map. Arrays are not to be written to.

    ``layers`` (H, W) uint8: what each cell is, and which obstacles, zones or temporary obstacles are nearer to it than
    the inscribed radius. ``clearance`` (H, W) float32: m from its middle to that of the nearest obstacle (or zone to
    keep out of), at most ``reach_m`` beyond the circumscribed radius. ``cost`` (H, W) float32: of a metre, >= 1, +inf
    where the middle of the body may not be (lethal). ``known`` is the field without temporary obstacles, None if it
    is this one.
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
        """From where on clearance costs nothing."""
        return self.footprint.circumscribed_m + self.settings.reach_m

    @property
    def lethal_m(self) -> float:
        """Under what clearance no way leads."""
        # A little over one cell at least: no way slips through a wall between two cells that touch by their corners.
        return max(self.footprint.inscribed_m, 1.01 * self.frame.resolution_m)


def cost_field(
    grid: OccupancyGrid,
    footprint: Footprint,
    zones: tuple[Zone, ...] = (),
    settings: CostSettings | None = None,
    previous: CostField | None = None,
) -> CostField:
    """The field of a map and its zones. ``previous``, of an earlier version of the same map, saves the work where
    nothing changed; the result is the same without it."""
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
    field = CostField(
        frame,
        layers,
        clearance=old.clearance.copy(),
        cost=old.cost.copy(),
        footprint=footprint,
        settings=settings,
        zones=zones,
        zone_clearance=zone_clearance,
        share=share,
    )
    for box in boxes:
        _fill(field, box)
    return field


def with_obstacles(field: CostField, points: NDArray[np.float64]) -> CostField:
    """``field`` with obstacles at ``points`` (N, 2), m on the map, that the map does not know: in place of those it had
    before."""
    from app.modules.behaviors.navigation.costmap.cost_kernels import overlay

    known = field.known or field
    cells, inside = known.frame.cells(points)
    rows, columns = cells[inside].T
    if not len(rows):
        return known
    there = np.zeros(known.layers.shape, dtype=np.uint8)
    there[rows, columns] = 1
    result = CostField(
        known.frame,
        known.layers | there * np.uint8(TEMPORARY),
        clearance=known.clearance.copy(),
        cost=known.cost.copy(),
        footprint=known.footprint,
        settings=known.settings,
        zones=known.zones,
        zone_clearance=known.zone_clearance,
        share=known.share,
        known=known,
    )
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
    # Rays leave single cells out, and beyond a window there are single rays: what most cells around are counts.
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
    """What the kernels of ``costing`` price by: lethal and reach (m), closeness, unknown."""
    unknown = {"free": 0.0, "costly": field.settings.unknown_cost, "blocked": math.inf}[field.settings.unknown]
    return field.lethal_m, field.reach_m, field.settings.closeness, unknown


def _distances(free: NDArray[np.bool_], resolution_m: float) -> NDArray[np.float32]:
    """m from each cell's middle to that of the nearest that is not free; very far where all are."""
    distances = np.asarray(cv2.distanceTransform(free.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))
    # Squares of distances between cells are whole numbers. OpenCV's roots are right to a last bit that depends on how
    # its threads share the rows, and on that bit which of two ways is taken.
    np.minimum(distances, _VERY_FAR, out=distances)
    np.sqrt(np.rint(np.square(distances, out=distances), out=distances), out=distances)
    return np.asarray(distances * np.float32(resolution_m), dtype=np.float32)


def _reach_cells(field: CostField) -> int:
    return math.ceil(field.reach_m / field.frame.resolution_m) + 1


def _boxes(changed: NDArray[np.generic], reach: int) -> Iterator[_Box]:
    """Boxes that together hold all cells within ``reach`` of a changed one, and do not overlap much."""
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
    """The box with a margin of ``reach`` within the array, and where in that the box itself is."""
    around, inner = [], []
    for side, length in zip(box, shape, strict=True):
        begin, end = max(side.start - reach, 0), min(side.stop + reach, length)
        around.append(slice(begin, end))
        inner.append(slice(side.start - begin, side.stop - begin))
    return (around[0], around[1]), (inner[0], inner[1])
