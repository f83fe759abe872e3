"""The dock's place in the world, and whether its contacts touch the body's charging plate.

A dock's frame D lies on the floor where its two plates meet; x points out of it, to the robot. The contacts are
sprung: they touch from where they stand out to where the dock's block stops the body.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.base.geometry import Pose2, wrap_angle
from app.robots.simulated.scenery.furniture import DOCK_CONTACTS_M
from app.robots.simulated.world_config import ObjectConfig, WorldConfig

KIND = "dock"
ASIDE_M = 0.05
"""Greatest offset (m) of the plate beside the dock's axis at which both contacts touch it."""
TURNED_RAD = math.radians(8)
"""Greatest angle (rad) between the robot's heading and the dock's axis at which both contacts touch the plate."""


def dock_poses(world: WorldConfig) -> tuple[Pose2, ...]:
    """``X_WD`` of every dock of the world."""
    return tuple(_pose(item) for item in world.objects if item.kind == KIND)


def touches(X_WB: Pose2, docks: Iterable[Pose2], plate_m: float) -> bool:
    """Whether the contacts of one of the ``docks`` touch the plate of a body at ``X_WB``, ``plate_m`` ahead of
    ``base_link``."""
    return any(_touches(X_WD.inverse() @ X_WB, plate_m) for X_WD in docks)


def _touches(X_DB: Pose2, plate_m: float) -> bool:
    turned = wrap_angle(X_DB.theta - math.pi)
    ahead = X_DB.x + plate_m * math.cos(X_DB.theta)
    aside = X_DB.y + plate_m * math.sin(X_DB.theta)
    return 0.0 <= ahead <= DOCK_CONTACTS_M and abs(aside) <= ASIDE_M and abs(turned) <= TURNED_RAD


def _pose(item: ObjectConfig) -> Pose2:
    # A piece of furniture looks to -y of its own frame.
    return Pose2(*item.at, wrap_angle(math.radians(item.yaw_deg) - math.pi / 2))
