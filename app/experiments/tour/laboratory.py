"""The laboratory as a kept map, drawn from the world's own shapes, with places in front of its posters.

The map's frame is that of a map which the robot begins where the world's body starts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from app.base.geometry import Pose2
from app.experiments.goals.reachable_floor import CELL_M, filled, outlines
from app.maps.library import MapLibrary
from app.maps.places import new_id
from app.maps.poster_places import Poster, in_front_of
from app.messages import OccupancyGrid, Place, read_only
from app.robots.config import RobotConfig
from app.robots.simulated.world_config import PosterConfig, WorldConfig

#: Beyond the world's outer walls, the map has so much more (m).
_MARGIN_M = 0.5


def origin_of(robot: RobotConfig) -> Pose2:
    """``X_WM``: where a map begins that the robot makes from its start."""
    return Pose2(robot.start.x, robot.start.y, math.radians(robot.start.heading_deg))


def drawn(world: WorldConfig, robot: RobotConfig, X_WM: Pose2) -> OccupancyGrid:
    """What ``robot`` could run into, as a map that begins at ``X_WM``; all else is free."""
    X_MW = X_WM.inverse()
    shapes = [X_MW.transform(outline) for outline in outlines(world, robot)]
    corners = np.concatenate(shapes)
    least, most = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    columns, rows = (math.ceil(float(side) / CELL_M) for side in most - least)
    taken = filled([shape - least for shape in shapes], (rows, columns))
    cells = np.where(taken, 100, 0).astype(np.int8)
    return OccupancyGrid(0.0, "map", read_only(cells), CELL_M, origin=(float(least[0]), float(least[1])), version=1)


def places(posters: Iterable[PosterConfig], X_WM: Pose2) -> tuple[Place, ...]:
    """A place in front of each poster, called as it is entitled."""
    found: dict[str, Place] = {}
    for number, each in enumerate(posters, 1):
        at = X_WM.inverse() @ Pose2(*each.at, math.radians(each.facing_deg))
        id_ = new_id(each.title, found)
        found[id_] = in_front_of(
            Place(id_, each.title, at.x, at.y, at.theta), Poster(number, each.text, at.x, at.y, heading=at.theta)
        )
    return tuple(found.values())


def keep(maps: MapLibrary, name: str, world: WorldConfig, robot: RobotConfig) -> None:
    """Draw the map ``name`` of ``world`` with its places, from the start of ``robot`` on. Raises OSError."""
    X_WM = origin_of(robot)
    maps.keep(name, drawn(world, robot, X_WM))
    maps.keep_places(name, places(world.posters, X_WM))
