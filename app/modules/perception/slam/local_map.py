"""The part of a finished map that a robot sees from where it is: what it follows itself on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from app.modules.perception.slam.types import Keyframe

#: So many keyframes at most of each quarter of headings, the nearest: enough for those behind a wall, too, which see
#: nothing of what the robot sees, and for a corridor that was mapped in the other direction.
_OF_A_QUARTER = 40
#: Keyframes farther away (m) see other places.
_AROUND_M = 8.0
#: Having moved so far (m), the robot sees another part; so much sooner where scans hardly fit any more.
STALE_M, DOUBTED_M = 1.5, 0.4


@dataclass(frozen=True, slots=True, eq=False)
class LocalMap:
    """``grid`` in the frame of keyframe ``nearest``, made for a robot at ``X_MB``."""

    grid: SurfelGrid
    nearest: int
    X_MB: Pose2


def local_map(keyframes: Mapping[int, Keyframe], poses: Mapping[int, Pose2], X_MB: Pose2) -> LocalMap:
    """What ``keyframes``, of which there is at least one, show of the place around ``X_MB``."""
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
