"""What mapping takes and gives: keyframes, matches, edges, and the state of it all that can be kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.information import Information


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan that is part of the map; where it is on the map, ``Slam.pose(id)`` says, which may change.

    All in ``base_link`` at ``stamp``, the sweep's motion taken out. ``points`` (N, 4) float32: x, y (m) and the unit
    normal of the surface there, towards the laser, or 0, 0 where it is not known; thinned, what is matched. ``ends``
    (K, 2) float32 m: where each ray ended; ``hits`` (K,) bool: whether on something, or just at the end of what the
    laser sees. ``origin`` (2,) float32 m: where the rays began. ``travelled_m`` since mapping began, by odometry, and
    more where scans did not fit: what the drift grows with.
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
    """Where the robot is, as one scan says.

    ``X_MB`` at the scan's stamp, ``X_MO`` = X_MB @ X_OB^-1. ``covariance`` (3, 3) float64 of X_MB's x, y (m^2) and
    theta (rad^2), along the map's axes. ``overlap`` is the share of the scan's points with anything of the map near
    them, ``inliers`` the share that lies on it. ``matched`` is False where the scan did not fit, and odometry alone
    led here. ``keyframe`` is the one this pose hangs on, ``X_KB`` the pose in it: after the graph was corrected, the
    better pose is ``slam.pose(match.keyframe) @ match.X_KB``. ``added``: the scan became that keyframe. ``moved``:
    the graph was corrected since the scan before, X_MO has jumped. ``off`` (m, rad): how far from where odometry led
    the scan was matched.
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
    """What was measured of keyframe ``b`` in the frame of ``a``: ``X_ab``.

    ``information`` is the inverse of its covariance along b's axes (``information.py``). A ``loop`` may be wrong (two
    places may look the same), so that its weight falls with its error; others follow the robot's motion.
    """

    a: int
    b: int
    X_ab: Pose2
    information: Information
    loop: bool


@dataclass(frozen=True, slots=True)
class Submap:
    """Keyframes next to each other, by id, that are looked at together; the first gives the frame."""

    id: int
    keyframes: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SlamState:
    """What must be kept to go on mapping: ``poses`` on the map of ``keyframes``, one each; ``submaps`` list ids."""

    keyframes: tuple[Keyframe, ...]
    poses: tuple[Pose2, ...]
    edges: tuple[Edge, ...]
    submaps: tuple[tuple[int, ...], ...]
