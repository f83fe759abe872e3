"""Leg inflation: room beside what may be legs, for people are wider than their legs in the scan.

Legs that the laser does not see any more keep their room: a person whom the robot passes is beside it when their legs
are behind the laser's field of view, and that is when they are nearest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings
from app.modules.leg_detection import legs, unknown_to

#: Range (m) beyond which people are too far to matter.
_FURTHEST_M = 3.0
#: Circles of the room, shares of its radius, with so many points each. Where the body stands in the outer ones, which
#: do not count under it, the inner ones keep it from coming nearer.
_CIRCLES, _RING = (1.0, 0.67, 0.33), 12
#: So near (m) to where a leg was, a candidate is this leg; within the second it stands still.
_SAME_M, _STILL_M = 0.15, 0.1
#: A place is the mean of so many scans: where noise moves it to and fro, a body beside it creeps nearer.
_MEAN = 5
#: A ray that goes so much farther (m) than a leg, within so much (m) to its sides, shows that it is gone.
_BEYOND_M, _ASIDE_M = 0.12, 0.03


@dataclass(frozen=True, slots=True)
class _Leg:
    """The near side of a leg at ``x``, ``y`` (m in ``odom``): the mean of the ``times`` that it was seen there, from
    ``first`` to ``last`` (s)."""

    x: float
    y: float
    first: float
    last: float
    times: int = 1

    def away_m(self, x: float, y: float) -> float:
        return math.hypot(self.x - x, self.y - y)

    def seen_at(self, x: float, y: float, stamp: float) -> _Leg:
        """The same leg, seen again."""
        if self.away_m(x, y) > _STILL_M:
            return _Leg(x, y, stamp, stamp)
        share = 1.0 / min(self.times + 1, _MEAN)
        mean = self.x + share * (x - self.x), self.y + share * (y - self.y)
        return _Leg(*mean, self.first, stamp, self.times + 1)


class LegMemory:
    """Legs around the robot that the map does not have, in ``odom``: those of the newest scan, and those that were seen
    before and may still stand where the laser does not look. They are kept as long as the local costmap keeps cells
    that the laser hit: ``forget_s``, and ``keep_s`` if they stood for ``steady_s``; none that a ray passes is kept."""

    def __init__(self, settings: CostmapSettings) -> None:
        self._settings = settings
        self._legs: list[_Leg] = []

    def see(self, scan: LaserScan, X_OB: Pose2, X_MO: Pose2, grid: OccupancyGrid) -> None:
        """Take a scan and the robot's pose at its stamp. ``grid``: the map, whose posts are no legs."""
        earlier, found = self._legs, list[_Leg]()
        for x, y in _candidates(scan, X_OB, X_MO, grid).tolist():
            same = min(earlier, key=lambda leg: leg.away_m(x, y), default=None)
            if same is None or same.away_m(x, y) > _SAME_M:
                found.append(_Leg(x, y, scan.stamp, scan.stamp))
            else:
                earlier = [leg for leg in earlier if leg is not same]
                found.append(same.seen_at(x, y, scan.stamp))
        passed = _passed(scan, X_OB, np.array([(leg.x, leg.y) for leg in earlier]).reshape(-1, 2))
        self._legs = found + [leg for leg, gone in zip(earlier, passed.tolist(), strict=True) if not gone]

    def room(self, now: float, room_m: float) -> NDArray[np.float64]:
        """Points (N, 2), m in ``odom``, within ``room_m`` around each leg that is there at ``now`` (s)."""
        self._legs = [leg for leg in self._legs if now - leg.last <= self._kept_s(leg)]
        middles = np.array([(leg.x, leg.y) for leg in self._legs]).reshape(-1, 2)
        turns = np.linspace(0.0, 2.0 * math.pi, _RING, endpoint=False)
        ring = np.stack((np.cos(turns), np.sin(turns)), axis=-1)
        disc = room_m * np.concatenate([share * ring for share in _CIRCLES])
        return np.asarray((middles[:, None, :] + disc).reshape(-1, 2))

    def _kept_s(self, leg: _Leg) -> float:
        settings = self._settings
        return settings.keep_s if leg.last - leg.first >= settings.steady_s else settings.forget_s


def _candidates(scan: LaserScan, X_OB: Pose2, X_MO: Pose2, grid: OccupancyGrid) -> NDArray[np.float64]:
    found = legs(scan, _FURTHEST_M)
    in_space = np.column_stack((found, np.zeros(len(found))))
    middles = np.asarray((X_OB.to_pose3() @ scan.X_BL).transform(in_space)[:, :2], dtype=np.float64)
    return np.asarray(middles[unknown_to(grid, X_MO.transform(middles))], dtype=np.float64)


def _passed(scan: LaserScan, X_OB: Pose2, places: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of ``places`` (N, 2), m in ``odom``, most rays towards them pass; none where no ray goes."""
    in_space = np.column_stack((places, np.full(len(places), scan.X_BL.translation[2])))
    seen = (X_OB.to_pose3() @ scan.X_BL).inverse().transform(in_space)
    passed = np.zeros(len(places), dtype=np.bool_)
    measured = scan.ranges >= scan.range_min
    for k, (x, y, _) in enumerate(seen.tolist()):
        away_m = math.hypot(x, y)
        aside = math.atan2(_ASIDE_M, away_m)
        ends = [(math.atan2(y, x) + side * aside - scan.angle_min) / scan.angle_increment for side in (-1, 1)]
        first, last = math.ceil(min(ends)), math.floor(max(ends))
        if 0 <= first <= last < len(scan.ranges):
            rays = slice(first, last + 1)
            through = measured[rays] & (scan.ranges[rays] > away_m + _BEYOND_M)
            passed[k] = 2 * int(through.sum()) > last - first + 1
    return passed
