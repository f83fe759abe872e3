"""From where a viewer looks (thesis, figure 3.4): the viewpoints, and the glide from one to another. Pure functions.

The camera is given in the *stage* S, a frame on the floor that the scene is drawn in. The stage lies where the
viewpoint wants it: on the base, turned with the head, turned with neither, or over the map. A camera that follows the
robot is thus never moved by the program, and a viewer's own orbit and zoom stay as they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle

#: ``behind`` the base, from above; ``aligned`` with robot and head, over its shoulder; ``free`` of both, turning with
#: neither; along the ``head``, not the base; through its camera; from the top; the whole map.
Viewpoint: TypeAlias = Literal["behind", "aligned", "free", "head", "first_person", "top", "map"]
VIEWPOINTS: tuple[Viewpoint, ...] = get_args(Viewpoint)
FIRST: Viewpoint = "behind"

#: How far ahead the point is that a view from behind looks at (m).
TARGET_M = 5.0
GLIDE_S = 0.35
#: What looks straight down keeps so much (m) beside the vertical: it says which way is up in the picture.
OFFSET_M = 0.01

_FOV = math.radians(60.0)
#: The camera's own picture and a margin around it.
_FIRST_PERSON_FOV = math.radians(52.0)
#: A viewer orbits this close (m) before the robot's camera: as good as turning the head.
_NEAR_M = 0.25
_TOP_M = 8.0
#: The robot is below the middle, from the top, by this (m): more of what is ahead is seen.
_TOP_AHEAD_M = 1.2
#: Without a map, as much of the floor (m) is shown as if there were one.
_NO_MAP_M = (16.0, 12.0)
_MAP_MARGIN = 1.12


@dataclass(frozen=True, slots=True)
class Shot:
    """A camera that looks at ``target`` (m, in S) from ``distance`` m away, ``azimuth`` and ``elevation`` (rad) of the
    way from the target to it; ``fov`` (rad) vertically. Up is up: it never rolls.

    ``elevation`` is less than a right angle, ``distance`` more than 0.
    """

    target: tuple[float, float, float]
    azimuth: float
    elevation: float
    distance: float
    fov: float = _FOV

    @property
    def eye(self) -> tuple[float, float, float]:
        """Position (m) of the camera in S."""
        across = self.distance * math.cos(self.elevation)
        x, y, z = self.target
        return (
            x + across * math.cos(self.azimuth),
            y + across * math.sin(self.azimuth),
            z + self.distance * math.sin(self.elevation),
        )

    @property
    def heading(self) -> float:
        """Azimuth (rad) in S of the way it looks."""
        return wrap_angle(self.azimuth + math.pi)


def shot_of(eye: NDArray[np.float64], target: NDArray[np.float64], fov: float) -> Shot:
    """The shot of a camera at ``eye`` that looks at ``target``, each (3,) m in S; kept a bit apart and beside the
    vertical where they are not."""
    x, y, z = (float(value) for value in eye - target)
    across = max(math.hypot(x, y), OFFSET_M)
    azimuth = math.atan2(y, x) if (x, y) != (0.0, 0.0) else math.pi
    at = (float(target[0]), float(target[1]), float(target[2]))
    return Shot(at, azimuth, math.atan2(z, across), math.hypot(across, z), fov)


@dataclass(frozen=True, slots=True)
class MapExtent:
    """The known part of the map: its middle with the map's axes, ``X_OC``, and its ``size`` (m) along them."""

    X_OC: Pose2
    size: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Anchors:
    """What a viewpoint lies by: the robot ``X_OB``, position (3,) m and direction (azimuth, elevation; rad) of its
    camera in ``base_link``, the heading (rad) in O that a free view keeps, the map, the view's width by its height."""

    X_OB: Pose2 = field(default_factory=Pose2)
    p_BC: tuple[float, float, float] = (0.0, 0.0, 1.2)
    gaze: tuple[float, float] = (0.0, 0.0)
    kept_heading: float = 0.0
    map: MapExtent | None = None
    aspect: float = 16 / 9


def stage_of(viewpoint: Viewpoint, anchors: Anchors) -> Pose2:
    """Where the stage of ``viewpoint`` is: ``X_OS``."""
    robot = anchors.X_OB
    match viewpoint:
        case "behind" | "aligned" | "top":
            return robot
        case "head" | "first_person":
            return Pose2(robot.x, robot.y, wrap_angle(robot.theta + anchors.gaze[0]))
        case "free":
            return Pose2(robot.x, robot.y, anchors.kept_heading)
        case "map":
            # What is to be up in the picture is the stage's x.
            middle = Pose2(robot.x, robot.y, anchors.kept_heading) if anchors.map is None else anchors.map.X_OC
            return Pose2(middle.x, middle.y, wrap_angle(middle.theta + math.pi / 2))


def shot(viewpoint: Viewpoint, anchors: Anchors) -> Shot:
    """The camera of ``viewpoint`` in its stage."""
    match viewpoint:
        case "behind":
            return _toward_target((-2.7, 0.0, 2.55), 0.45)
        case "aligned":
            return _toward_target((-1.15, 0.0, 1.85), 0.75)
        case "head":
            return _toward_target((-1.7, 0.0, 2.0), 0.7)
        case "free":
            return shot_of(np.array([-3.0, 1.9, 3.0]), np.array([0.6, 0.0, 0.5]), _FOV)
        case "first_person":
            return _through_camera(anchors)
        case "top":
            return _down(_TOP_M, _TOP_AHEAD_M)
        case "map":
            return _down(_map_height(anchors), 0.0)


def _toward_target(eye: tuple[float, float, float], height: float) -> Shot:
    """From ``eye`` toward the point :data:`TARGET_M` ahead at ``height`` (m). What it turns and zooms about is on this
    way, above the robot: about the target, a turn would leave the robot behind."""
    begin, end = np.array(eye), np.array([TARGET_M, 0.0, height])
    share = -eye[0] / (TARGET_M - eye[0])
    return shot_of(begin, begin + share * (end - begin), _FOV)


def _through_camera(anchors: Anchors) -> Shot:
    azimuth, elevation = anchors.gaze
    x, y, z = anchors.p_BC
    cos, sin = math.cos(-azimuth), math.sin(-azimuth)
    eye = np.array([cos * x - sin * y, sin * x + cos * y, z])
    elevation = min(max(elevation, -1.4), 1.4)
    ahead = np.array([math.cos(elevation), 0.0, math.sin(elevation)])
    return shot_of(eye, eye + _NEAR_M * ahead, _FIRST_PERSON_FOV)


def _down(height: float, ahead: float) -> Shot:
    return shot_of(np.array([ahead - OFFSET_M, 0.0, height]), np.array([ahead, 0.0, 0.0]), _FOV)


def _map_height(anchors: Anchors) -> float:
    width, height = _NO_MAP_M if anchors.map is None else anchors.map.size
    tall = max(height, width / max(anchors.aspect, 0.2), 4.0)
    return _MAP_MARGIN * tall / 2 / math.tan(_FOV / 2)


def smoothstep(share: float) -> float:
    """From 0 to 1, slow at both ends; beyond them as at them."""
    x = min(max(share, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def between(begin: Shot, end: Shot, share: float) -> Shot:
    """The shot ``share`` of the way from ``begin`` to ``end``, the shorter way round; exactly ``end`` from 1 on."""
    if share >= 1.0:
        return end
    e = max(share, 0.0)

    def mixed(a: float, b: float) -> float:
        return a + e * (b - a)

    x, y, z = (mixed(a, b) for a, b in zip(begin.target, end.target, strict=True))
    return Shot(
        (x, y, z),
        begin.azimuth + e * wrap_angle(end.azimuth - begin.azimuth),
        mixed(begin.elevation, end.elevation),
        # By ratios: half-way is as much nearer than the one as it is farther than the other.
        math.exp(mixed(math.log(begin.distance), math.log(end.distance))),
        mixed(begin.fov, end.fov),
    )


@dataclass(frozen=True, slots=True)
class Glide:
    """From a shot ``begin`` on a stage that lay at ``offset`` (``X_TS``) of its end, since ``began`` (s); it goes on
    for the share ``hold`` (0 to 1) of its time, and stays there."""

    viewpoint: Viewpoint
    began: float
    begin: Shot
    offset: Pose2
    hold: float = 1.0

    def share(self, now: float) -> float:
        """How far it is at ``now`` (s): 0 to 1, eased."""
        return smoothstep(min((now - self.began) / GLIDE_S, self.hold))

    def stage(self, now: float, anchors: Anchors) -> Pose2:
        """``X_OS`` at ``now``: the viewpoint's own from the end on."""
        own = stage_of(self.viewpoint, anchors)
        share = self.share(now)
        return own if share >= 1.0 else own @ self.offset.interpolate(Pose2(), share)

    def shot(self, now: float, anchors: Anchors) -> Shot:
        """The camera at ``now``: exactly the viewpoint's from the end on."""
        return between(self.begin, shot(self.viewpoint, anchors), self.share(now))


@dataclass(frozen=True, slots=True)
class Choice:
    """What one viewer chose last: its ``viewpoint``, the ``number`` of the choice, how often its user has taken the
    camera in hand (``grabs``), the ``soft_limit`` (rad) within which the head follows the view (None: it does not), and
    the share of its time at which a glide to it is to ``hold``."""

    viewpoint: Viewpoint = FIRST
    number: int = 0
    grabs: int = 0
    soft_limit: float | None = None
    hold: float = 1.0
