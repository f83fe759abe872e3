"""The world as known at one moment, as far as it is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from app.base.geometry import CameraModel, Pose2, Pose3
from app.console.view.foreseen import Motions
from app.messages import (
    EncodedImage,
    ExternalForces,
    Landmarks,
    LaserScan,
    Localization,
    OccupancyGrid,
    PlacedPercepts,
    PlannedPath,
    PointCloud,
    Twist,
    Zones,
)


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture of the robot's ``camera`` (as it is before the picture is reduced), taken at ``X_OC``."""

    image: EncodedImage
    camera: CameraModel
    X_OC: Pose3


@dataclass(frozen=True, slots=True)
class World:
    """Each part is replaced as a whole, so that ``is`` shows whether it is new.

    ``robot`` is ``X_OB`` at ``stamp`` (s, the robot's clock; None before it is known), ``joints`` are the positions
    (rad, m) of its joints by name at that instant. ``scan`` comes with the pose of its own instant, as the cloud does
    by itself, and what is ``perceived`` of people. ``forces`` are on the body, which moves by ``applied``, and goes on
    by ``motions`` (None in a recording). ``picture`` is there while a viewer looks through the camera.
    ``localization`` says where that lies which is on the map: ``map`` itself, ``zones``, the ``path`` and the ``goal``
    (x, y in m, heading in rad or None). The ``costmap`` is in ``odom``.
    """

    robot: Pose2 | None = None
    joints: Mapping[str, float] | None = None
    scan: tuple[LaserScan, Pose2] | None = None
    cloud: PointCloud | None = None
    landmarks: Landmarks | None = None
    perceived: PlacedPercepts | None = None
    forces: ExternalForces | None = None
    localization: Localization | None = None
    map: OccupancyGrid | None = None
    zones: Zones | None = None
    path: PlannedPath | None = None
    goal: tuple[float, float, float | None] | None = None
    costmap: OccupancyGrid | None = None
    picture: Picture | None = None
    applied: Twist | None = None
    motions: Motions | None = None
    stamp: float | None = None
    #: The robot's clock (s).
    now: float = 0.0
