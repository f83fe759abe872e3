"""Data types of mapping: keyframes, matches, edges, submaps, and the state that can be saved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.information import Information

#: Number of poses that landmarks suggest and that are remembered while the robot searches its own.
MOST_SUGGESTED = 8


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan that is part of the map; its pose on the map is ``Slam.pose(id)`` and may change.

    All in ``base_link`` at ``stamp``, corrected for the motion during the sweep. ``points`` (N, 4) float32: x, y (m)
    and the unit normal of the surface there, towards the laser, or 0, 0 if unknown; thinned, for matching. ``ends`` (K,
    2) float32 m: the rays' ends; ``hits`` (K,) bool: whether there was a return, else the end of the laser's range.
    ``origin`` (2,) float32 m: origin of the rays. ``travelled_m``: distance since mapping began, by odometry, plus a
    surcharge where scans did not fit; the drift is proportional to it.
    """

    id: int
    stamp: float
    points: NDArray[np.float32]
    ends: NDArray[np.float32]
    hits: NDArray[np.bool_]
    origin: NDArray[np.float32]
    travelled_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Pose of the robot by one scan.

    ``X_MB`` at the scan's stamp, ``X_MO`` = X_MB @ X_OB^-1. ``covariance`` (3, 3) float64 of X_MB's x, y (m^2) and
    theta (rad^2), along the map's axes. ``overlap`` is the share of the scan's points with anything of the map near
    them, ``inliers`` the share that lies on it. ``matched`` is False where the scan did not fit and the pose is
    odometry's. ``keyframe``: the keyframe this pose is attached to, ``X_KB`` the pose in it: after a correction of the
    graph the better pose is ``slam.pose(match.keyframe) @ match.X_KB``. ``added``: the scan became that keyframe.
    ``moved``: the graph was corrected since the scan before, X_MO has jumped. ``off`` (m, rad): distance of the match
    from odometry's prediction.
    """

    stamp: float
    X_MB: Pose2
    X_MO: Pose2
    covariance: NDArray[np.float64]
    overlap: float
    inliers: float
    matched: bool
    keyframe: int
    X_KB: Pose2
    added: bool
    moved: bool
    off: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Edge:
    """Measured pose of keyframe ``b`` in the frame of ``a``: ``X_ab``.

    ``information`` is the inverse of its covariance along b's axes (``information.py``). A ``loop`` may be wrong
    (similar places), so that its weight falls with its error; other edges follow the robot's motion.
    """

    a: int
    b: int
    X_ab: Pose2
    information: Information
    loop: bool


@dataclass(frozen=True, slots=True)
class Submap:
    """Adjacent keyframes, by id, with a common surfel grid; the first defines the frame."""

    id: int
    keyframes: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SlamState:
    """The state needed to resume mapping: ``poses`` on the map of ``keyframes``, one each; ``submaps`` list ids."""

    keyframes: tuple[Keyframe, ...]
    poses: tuple[Pose2, ...]
    edges: tuple[Edge, ...]
    submaps: tuple[tuple[int, ...], ...]
