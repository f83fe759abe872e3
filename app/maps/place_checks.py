"""Whether the robot could stand at a place, by what the map, its zones and its posters say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.maps.places import pose_of
from app.maps.poster_places import STAND_OFF_M, Poster, followed
from app.messages import OccupancyGrid, Place, Zone

#: Cells of this occupancy (0 to 100) and more are obstacles.
OCCUPIED = 65


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What places are judged by: ``posters`` on the map (None: not known), its cells (None: no map yet) and zones.

    The robot covers at least ``radius_m`` around itself, and stops ``stand_off_m`` before posters.
    """

    posters: Sequence[Poster] | None
    grid: OccupancyGrid | None
    zones: Sequence[Zone]
    radius_m: float
    stand_off_m: float = STAND_OFF_M


def judged(places: Sequence[Place], by: Surroundings) -> tuple[Place, ...]:
    """``places`` where their posters have them now, each with its problem."""
    return tuple(_judged(place, by) for place in places)


def obstruction(pose: Pose2, grid: OccupancyGrid | None, zones: Sequence[Zone], radius_m: float) -> str:
    """Why a robot that covers at least ``radius_m`` around itself cannot stand at ``pose`` on the map, in words; "" if
    nothing is known against it."""
    for zone in zones:
        if zone.kind == "keep_out" and _inside(zone, pose):
            return f"it is in the keep-out zone {zone.name}"
    if grid is None:
        return ""
    near = _cells_near(pose, grid, radius_m)
    return "it is in an obstacle of the map" if near.size and int(near.max()) >= OCCUPIED else ""


def doubt(pose: Pose2, grid: OccupancyGrid | None) -> str:
    """What speaks against ``pose`` being on the map at all, in words; "" for nothing."""
    if grid is None:
        return ""
    here = _cells_near(pose, grid, 0.0)
    if here.size == 0:
        return "it is beyond the map"
    return "it is where the map is not known" if int(here.max()) < 0 else ""


def inscribed_radius_m(footprint: Sequence[tuple[float, float]]) -> float:
    """Radius (m) of the greatest disc about ``base_link`` within ``footprint`` (corners in order, m); 0 without one."""
    if len(footprint) < 3:
        return 0.0
    polygon = np.array(footprint, np.float32)[:, None]
    return max(0.0, float(cv2.pointPolygonTest(polygon, (0.0, 0.0), measureDist=True)))


def _judged(place: Place, by: Surroundings) -> Place:
    place, lack = (place, "") if by.posters is None else followed(place, by.posters, by.stand_off_m)
    pose = pose_of(place)
    problem = obstruction(pose, by.grid, by.zones, by.radius_m) or lack or doubt(pose, by.grid)
    return replace(place, problem=problem)


def _inside(zone: Zone, pose: Pose2) -> bool:
    # Relative to the place, so that 32 bits are enough far from the map's origin.
    polygon = (zone.polygon - np.array([pose.x, pose.y])).astype(np.float32)[:, None]
    return cv2.pointPolygonTest(polygon, (0.0, 0.0), measureDist=False) >= 0


def _cells_near(pose: Pose2, grid: OccupancyGrid, radius_m: float) -> NDArray[np.int8]:
    """The cells whose middle is within ``radius_m`` of ``pose``, and the one that it is in; empty beyond the grid."""
    cell = grid.resolution_m
    u, v = (pose.x - grid.origin[0]) / cell, (pose.y - grid.origin[1]) / cell
    reach = radius_m / cell
    height, width = grid.cells.shape
    rows = np.arange(max(0, math.floor(v - reach)), min(height, math.floor(v + reach) + 1))
    columns = np.arange(max(0, math.floor(u - reach)), min(width, math.floor(u + reach) + 1))
    if not rows.size or not columns.size:
        return np.empty(0, np.int8)
    square = (rows[:, None] + 0.5 - v) ** 2 + (columns[None, :] + 0.5 - u) ** 2
    within = (square <= reach**2) | ((rows[:, None] == math.floor(v)) & (columns[None, :] == math.floor(u)))
    near: NDArray[np.int8] = grid.cells[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1][within]
    return near
