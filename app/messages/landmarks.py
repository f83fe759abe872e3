"""What joins landmarks and the map: its keyframes, the robot's pose by a landmark, and landmarks that have moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages.base import PerceptKind

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """The keyframes of the map in use, and where the robot is on it by the scan taken at ``stamp``.

    ``X_MO``, ``X_MB``, ``covariance`` and ``state`` are those of :class:`Localization`, consistent with ``poses``.
    ``keyframe`` is the id of the keyframe that the robot's pose is attached to, -1 where there is none. ``ids`` (N,)
    int64, ascending; ``poses`` (N, 3) float64: x, y (m), theta (rad) of each on the map; ``travelled_m`` (N,) float64:
    distance driven from the begin of the map to each. All are empty for a map that was saved without its graph.

    ``version`` grows with every message, over all maps. ``removed`` (R,) int64: ids of keyframes that were pruned since
    the message before; what is anchored to one belongs to the keyframe ``into`` (R,) int64, in whose frame the removed
    one is at ``X_IR`` (R, 3) float64: x, y, theta.
    """

    stamp: float
    version: int
    state: str
    X_MO: Pose2
    X_MB: Pose2
    covariance: NDArray[np.float64]
    keyframe: int
    ids: NDArray[np.int64]
    poses: NDArray[np.float64]
    travelled_m: NDArray[np.float64]
    removed: NDArray[np.int64]
    into: NDArray[np.int64]
    X_IR: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkPose:
    """A hypothesis of the robot's pose by one landmark seen at ``stamp``: ``X_MO`` places ``odom`` on the map.

    ``covariance`` (3, 3) float64 of the robot's x, y (m^2) and theta (rad^2). ``landmark`` is its id, ``text`` what it
    says. It is wrong where the landmark hangs elsewhere by now, or its text hangs in several places.
    """

    stamp: float
    X_MO: Pose2
    covariance: NDArray[np.float64]
    landmark: int
    text: str


@dataclass(frozen=True, slots=True)
class DisplacedLandmark:
    """A landmark of the map, ``id`` with its ``text`` at ``p_MQ`` (m), that hangs at ``p_MR`` now, as landmark
    ``now``."""

    id: int
    text: str
    p_MQ: Point
    now: int
    p_MR: Point


@dataclass(frozen=True, slots=True)
class DisplacedLandmarks:
    """The landmarks that hang elsewhere than the map says; published with the landmarks, without any too."""

    percept_kind: ClassVar[PerceptKind] = PerceptKind("displaced", "{subject} elsewhere than on the map")

    stamp: float
    landmarks: tuple[DisplacedLandmark, ...]

    @property
    def frame(self) -> str:
        """They are on the map, whatever saw them."""
        return "map"

    @property
    def subjects(self) -> Mapping[str, float]:
        """Their texts, each surely."""
        return {landmark.text: 1.0 for landmark in self.landmarks}
