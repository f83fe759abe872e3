"""Keyframes and sightings for tests of landmarks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from app.base.geometry import Pose2
from app.messages import Keyframes, Landmark
from app.modules.perception.landmarks.landmark_map import LandmarkMap
from app.modules.perception.landmarks.types import Seen

Removed = tuple[int, int, Pose2]


def keyframes(
    poses: Mapping[int, Pose2],
    at: Pose2,
    *,
    keyframe: int | None = None,
    state: str = "mapping",
    X_OB: Pose2 | None = None,
    removed: Sequence[Removed] = (),
    version: int = 1,
    sigma: tuple[float, float, float] = (0.01, 0.01, 0.003),
) -> Keyframes:
    """The keyframes at ``poses`` with the robot at ``at`` on the map, attached to ``keyframe`` (default: the newest).

    ``X_OB``: the robot by odometry; default: without drift, so that odom is the map.
    """
    ids = sorted(poses)
    return Keyframes(
        stamp=float(version),
        version=version,
        state=state,
        X_MO=at @ (X_OB or at).inverse(),
        X_MB=at,
        covariance=np.diag(np.square(sigma)),
        keyframe=(max(ids, default=-1) if keyframe is None else keyframe),
        ids=np.array(ids, np.int64),
        poses=np.array([(poses[id].x, poses[id].y, poses[id].theta) for id in ids], np.float64).reshape(-1, 3),
        travelled_m=np.array([float(id) for id in ids]),
        removed=np.array([id for id, _, _ in removed], np.int64),
        into=np.array([into for _, into, _ in removed], np.int64),
        X_IR=np.array([(X.x, X.y, X.theta) for _, _, X in removed], np.float64).reshape(-1, 3),
    )


def seen(robot: Pose2, p: tuple[float, float, float], heading: float, sigma_m: float = 0.03) -> Seen:
    """What the robot at ``robot`` measures of a code at ``p`` that looks along ``heading``, without error."""
    x, y = robot.inverse().transform(np.array(p[:2])).tolist()
    return Seen(np.array([x, y, p[2]]), sigma_m, heading - robot.theta, 0.05)


def only(landmarks: LandmarkMap) -> Landmark:
    """The one landmark there is."""
    (found,) = landmarks.message(0.0).landmarks
    return found


def turned(one: float, other: float) -> float:
    """Angle (rad) between two directions."""
    return abs(math.remainder(one - other, math.tau))
