"""Settings of mapping: one configuration for all places, lasers and bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2


@dataclass(frozen=True, slots=True)
class SlamSettings:
    """Lengths in m, angles in rad, shares in [0, 1]; a submap's cell of 0.1 m is fixed (``surfels.CELL_M``)."""

    #: Greatest range of matched readings (m): farther ones are sparse.
    range_max_m: float = 25.0
    #: Distance below which neighbouring readings are merged.
    thinning_m: float = 0.03
    #: Distance and angle between keyframes.
    keyframe_m: float = 0.3
    keyframe_rad: float = 0.25
    #: Number of keyframes of a submap; each is also in the submap before or after.
    submap_keyframes: int = 24
    #: Odometry's standard deviation: at rest, per m driven, per rad turned.
    odometry_floor_m: float = 0.03
    odometry_m_per_m: float = 0.25
    odometry_m_per_rad: float = 0.1
    odometry_floor_rad: float = 0.02
    odometry_rad_per_rad: float = 0.4
    odometry_rad_per_m: float = 0.1
    #: Inlier share below which a wider search for a better pose begins. A scan that turned into a similar place has two
    #: thirds.
    rescue_below: float = 0.75
    #: Inlier share below which the drift exceeds that of odometry.
    poor_below: float = 0.55
    #: Inlier share below which the scan is ignored and odometry is used.
    lost_below: float = 0.25
    #: Misfitting scans are mapped only at this distance (m, rad) from the last keyframe, so that a briefly covered
    #: laser leaves no trace. From there mapping continues at odometry's pose.
    lost_keyframe_m: float = 1.0
    lost_keyframe_rad: float = 1.0
    #: Radius of the loop search, its increase per m driven since the place was last seen, and its maximum.
    loop_window_m: float = 1.0
    loop_window_m_per_m: float = 0.035
    loop_window_max_m: float = 12.0
    #: Inlier share of a loop on the old submap ...
    loop_inliers: float = 0.62
    #: ... and least score of the correlative search.
    loop_score: float = 0.55
    #: Displacement by a loop from which a second consistent one is required.
    loop_alone_m: float = 0.6
    #: Greatest number of keyframes per square metre and sector of headings, ...
    keyframes_per_m2: int = 10
    #: ... and number of sectors.
    heading_sectors: int = 4

    def is_far(self, X_KB: Pose2, lost: bool) -> bool:
        """Whether a scan at ``X_KB`` from the last keyframe becomes the next one; ``lost``: it fits nowhere."""
        metres, radians = self.keyframe_m, self.keyframe_rad
        if lost:
            metres, radians = self.lost_keyframe_m, self.lost_keyframe_rad
        return math.hypot(X_KB.x, X_KB.y) > metres or abs(X_KB.theta) > radians

    def odometry_sigmas(self, distance_m: float, turn_rad: float) -> tuple[float, float]:
        """Standard deviations (m, rad) of a motion measured by odometry."""
        turn = abs(turn_rad)
        return (
            self.odometry_floor_m + self.odometry_m_per_m * distance_m + self.odometry_m_per_rad * turn,
            self.odometry_floor_rad + self.odometry_rad_per_rad * turn + self.odometry_rad_per_m * distance_m,
        )
