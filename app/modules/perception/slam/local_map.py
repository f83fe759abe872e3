"""Local map for localization: the part of a finished map around the robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from app.modules.perception.slam.types import Keyframe

#: Greatest number of keyframes per quarter of headings, the nearest ones: enough to include those of this side of a
#: wall, and for a corridor that was mapped in the other direction.
_OF_A_QUARTER = 40
#: Greatest distance (m) of a keyframe.
_AROUND_M = 8.0
#: Distance (m) after which the local map is made again; a shorter one where scans hardly fit.
STALE_M, DOUBTED_M = 1.5, 0.4


@dataclass(frozen=True, slots=True, eq=False)
class LocalMap:
    """Surfel ``grid`` in the frame of keyframe ``nearest``, made for a robot at ``X_MB``."""

    grid: SurfelGrid
    nearest: int
    X_MB: Pose2


def local_map(keyframes: Mapping[int, Keyframe], poses: Mapping[int, Pose2], X_MB: Pose2) -> LocalMap:
    """The local map of ``keyframes`` (at least one) around ``X_MB``."""
    ids = list(poses)
    at = np.array([(p.x, p.y, p.theta) for p in poses.values()])
    away = np.hypot(at[:, 0] - X_MB.x, at[:, 1] - X_MB.y)
    quarter = np.floor((at[:, 2] - X_MB.theta) / (0.5 * np.pi) + 0.5).astype(np.int64) % 4
    order = np.argsort(away, kind="stable")
    room = [_OF_A_QUARTER] * 4
    chosen: list[int] = []
    for row in order:
        if away[row] > _AROUND_M and chosen:
            break
        if room[quarter[row]] > 0:
            room[quarter[row]] -= 1
            chosen.append(ids[row])
    nearest = chosen[0]
    X_SM = poses[nearest].inverse()
    return LocalMap(surfel_grid((keyframes[k].points, X_SM @ poses[k]) for k in chosen), nearest, X_MB)
