"""Localization, maps, paths and navigation status.

Frame M is ``map``, fixed in the world: ``map -> odom -> base_link``. ``X_MO`` jumps when a loop is closed or the robot
is relocalized; ``odom`` never jumps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2


@dataclass(frozen=True, slots=True, eq=False)
class Localization:
    """Pose of the robot on the map by the scan taken at ``stamp``.

    ``X_MO`` places ``odom`` on the map, ``X_MB = X_MO @ X_OB(stamp)`` the robot. ``covariance`` (3, 3) float64 of
    ``X_MB``'s x, y (m^2) and theta (rad^2), along the map's axes. ``overlap`` in [0, 1] is the share of the scan that
    fits the map. ``map`` names the map, "" while it has no name. ``state`` is ``mapping`` (the map grows), ``tracking``
    (the pose is followed on a map that stays), ``searching`` (relocalization on the map) or ``lost`` (scans have not
    fitted the map for a while): only the first two are good enough for driving.
    """

    stamp: float
    X_MO: Pose2
    X_MB: Pose2
    covariance: NDArray[np.float64]
    state: str
    overlap: float
    map: str


@dataclass(frozen=True, slots=True, eq=False)
class OccupancyGrid:
    """An occupancy grid in ``frame`` (``map`` or ``odom``).

    ``cells`` (H, W) int8: −1 unknown, 0 free … 100 occupied (as ROS's ``nav_msgs/OccupancyGrid``). Cell [row, column]
    covers x from ``origin[0] + column * resolution_m`` and y from ``origin[1] + row * resolution_m``, one resolution
    each. ``version`` grows with every change of the cells.
    """

    stamp: float
    frame: str
    cells: NDArray[np.int8]
    resolution_m: float
    origin: tuple[float, float]
    version: int


@dataclass(frozen=True, slots=True, eq=False)
class PlannedPath:
    """A path to the goal: ``poses`` (N, 3) float64, x, y (m) and heading (rad) in ``frame``; empty without a path."""

    stamp: float
    frame: str
    poses: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class NavigationStatus:
    """Status of a behavior that drives to a goal.

    ``behavior`` is its name. ``goal``: the desired pose (on the map; heading NaN for any), None without one;
    ``target``: the end of the path: the nearest reachable place, if the goal is not reachable. ``remaining_m``: rest of
    the path, None without one. ``progress_stamp``: the last time the rest of the path was shorter than ever before for
    this goal. ``recoveries``: number of recovery actions since the goal was given. ``state`` is ``idle``, ``planning``,
    ``following`` a path, ``recovering`` (clears, backs off, turns), ``waiting`` (for a pose, a map, fresh sensors, a
    free path), ``arrived`` or ``unreachable``; ``reason``: the cause in words, and what would help. ``period_s``: the
    longest recent time between two commands, None where it was not measured.
    """

    stamp: float
    behavior: str
    state: str
    reason: str
    goal: Pose2 | None = None
    target: Pose2 | None = None
    remaining_m: float | None = None
    progress_stamp: float | None = None
    recoveries: int = 0
    period_s: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Zone:
    """A part of the map that the robot keeps out of (``kind`` is ``keep_out``) or drives slowly in (``slow``).

    ``polygon`` (N, 2) float64: its corners, at least 3, m on the map. ``speed`` is the share of the robot's greatest
    speed allowed there, in ]0, 1]; of a ``keep_out`` zone it means nothing.
    """

    name: str
    kind: str
    polygon: NDArray[np.float64]
    speed: float


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """Every zone of the map in use; published when one changes."""

    stamp: float
    zones: tuple[Zone, ...]


#: How a place came to be: by its coordinates, where the robot stood, or in front of a poster (a QR code), with which it
#: moves.
PlaceSource = Literal["hand", "here", "poster"]


@dataclass(frozen=True, slots=True)
class Place:
    """A named pose on the map in use: ``x``, ``y`` (m) and ``heading`` (rad, in [-π, π)).

    ``id`` never changes; ``name`` is for people, and no two places of a map share one. A place of the source
    ``poster`` is in front of the landmark with the number ``landmark`` and the text ``poster``; 0 and "" for others.
    ``problem``: why the robot cannot stand there, or what is doubtful about it, in words; "" for nothing.
    """

    id: str
    name: str
    x: float
    y: float
    heading: float
    source: PlaceSource = "hand"
    poster: str = ""
    landmark: int = 0
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Places:
    """Every place of the map in use, in the order of their making; published when one changes."""

    stamp: float
    places: tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class GivenUpGoal:
    """A goal (on the map; a heading that was not asked for is NaN) that was given up at ``stamp``, and why in words."""

    stamp: float
    goal: Pose2
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class NavigationReport:
    """Where the robot goes: the status of the behavior at work, with what belongs to it. ``stamp`` is the status's.

    ``behavior`` is "" and ``state`` ``idle`` before any behavior has published; ``goal``, ``target``, ``recoveries``
    and ``state`` are those of ``NavigationStatus``. ``remaining_m`` is None where it is not known. ``desire`` is the id
    of the strongest desire of class GoTo. ``path`` (N, 2) float64, x and y (m) on the map, at most 200 points; none
    while the behavior at work follows none. ``given_up`` is the goal that was given up last, until another is desired.
    """

    stamp: float
    behavior: str
    state: str
    reason: str
    goal: Pose2 | None
    target: Pose2 | None
    remaining_m: float | None
    recoveries: int
    desire: str | None
    path: NDArray[np.float64]
    given_up: GivenUpGoal | None
