"""Transient obstacles: obstacles that the map does not have, kept on the map for a limited time, so that paths avoid
them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.costmap.inflation import CostField
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow


@dataclass(frozen=True, slots=True, eq=False)
class TransientObstacles:
    """``points`` (N, 2) float64 m on the map, each last seen at ``stamps`` (N,) float64 (robot's clock, s)."""

    points: NDArray[np.float64]
    stamps: NDArray[np.float64]

    @staticmethod
    def none() -> TransientObstacles:
        return TransientObstacles(np.empty((0, 2)), np.empty(0))


def remember(
    known: TransientObstacles,
    around: CostmapWindow,
    X_MO: Pose2,
    field: CostField,
    keep_s: float = 15.0,
    on_map_m: float = 0.15,
) -> TransientObstacles:
    """``known``, updated with the obstacles around the robot that are not on the map.

    Within the costmap's window the current obstacles replace older ones; outside, obstacles seen within ``keep_s``
    stay. An obstacle is on the map if it is within ``on_map_m`` of an obstacle of ``field`` (transient ones aside): the
    measured place of a wall never equals its place on the map exactly.
    """
    old, stamps = known.points, known.stamps
    if len(old):
        places = X_MO.inverse().transform(old) - np.array(around.known_from)
        keep = (stamps >= around.stamp - keep_s) & ~((places >= 0.0) & (places < around.known_m)).all(axis=1)
        old, stamps = old[keep], stamps[keep]
    new = off_map(X_MO.transform(around.obstacles), field, on_map_m)
    return TransientObstacles(np.concatenate((old, new)), np.concatenate((stamps, np.full(len(new), around.stamp))))


def off_map(points: NDArray[np.float64], field: CostField, on_map_m: float = 0.15) -> NDArray[np.float64]:
    """Cells (their middles) of ``points`` (N, 2), m on the map, further than ``on_map_m`` from the map's obstacles."""
    field = field.known or field
    cells, inside = field.frame.cells(points)
    cells = np.unique(cells[inside], axis=0)
    cells = cells[field.clearance[cells[:, 0], cells[:, 1]] > on_map_m]
    frame = field.frame
    return np.asarray((cells[:, ::-1] + 0.5) * frame.resolution_m + np.array([frame.x, frame.y]))
