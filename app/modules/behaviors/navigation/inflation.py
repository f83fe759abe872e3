"""What a metre of way costs everywhere on the map: obstacles inflated by the footprint, zones, unknown space.

The field is made anew only where its map changed (``previous``); what stands in the way but not on the map is laid over
it (:func:`with_obstacles`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.footprint import Footprint
from app.modules.behaviors.navigation.grid import GridFrame

#: What a cell is (bits of :attr:`CostField.layers`).
OCCUPIED, KEEP_OUT, TEMPORARY, UNKNOWN = 1, 2, 4, 8


@dataclass(frozen=True, slots=True)
class CostSettings:
    """What is dear. A metre in the open costs 1, in a slow zone 1 / its share of speed (the time it takes).

    Nearer to an obstacle than the inscribed radius no way leads; there a metre costs ``closeness`` more, and less and
    less (quadratically) to ``reach_m`` beyond the circumscribed radius: ways keep to the middle of corridors narrower
    than twice that. ``unknown`` is ``free``, ``costly`` (``unknown_cost`` more a metre: a last resort) or ``blocked``.
    Cells of at least ``occupied_from`` (0 to 100) are obstacles.
    """

    reach_m: float = 0.75
    closeness: float = 6.0
    unknown: str = "costly"
    unknown_cost: float = 10.0
    occupied_from: int = 65


@dataclass(frozen=True, slots=True, eq=False)
class CostField:
    """What going costs on the map. ``layers`` (H, W) uint8: what each cell is. ``clearance`` (H, W) float32: m from its
    middle to the nearest obstacle's or keep-out zone's, at most ``reach_m`` beyond the circumscribed radius. ``cost``
    (H, W) float32: of a metre, >= 1, +inf where the body may not be (lethal). Arrays are not to be written to.
    """

    frame: GridFrame
    layers: NDArray[np.uint8]
    clearance: NDArray[np.float32]
    cost: NDArray[np.float32]
    footprint: Footprint
    settings: CostSettings
    zones: tuple[Zone, ...]


def cost_field(
    grid: OccupancyGrid,
    footprint: Footprint,
    zones: tuple[Zone, ...] = (),
    settings: CostSettings | None = None,
    previous: CostField | None = None,
) -> CostField:
    """The field of a map and its zones. ``previous``, of an earlier version of the same map (it may have grown), saves
    the work where nothing changed; the result is the same without it."""
    raise NotImplementedError


def with_obstacles(field: CostField, points: NDArray[np.float64]) -> CostField:
    """``field`` with obstacles at ``points`` (N, 2), m on the map, that the map does not know (layer TEMPORARY)."""
    raise NotImplementedError
