"""What can be tuned of mapping: one configuration for all places, lasers and bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2


@dataclass(frozen=True, slots=True)
class SlamSettings:
    """Lengths in m, angles in rad, shares in [0, 1]; a submap's cell of 0.1 m is fixed (``surfels.CELL_M``)."""

    #: Readings beyond it are not matched: they are few, and thin out over the walls.
    range_max_m: float = 25.0
    #: Neighbouring readings nearer to each other than this are one point.
    thinning_m: float = 0.03
    #: A keyframe is made when the robot is so far, or turned so much, from the last one.
    keyframe_m: float = 0.3
    keyframe_rad: float = 0.25
    #: Keyframes of a submap; each also lies in the one before or after.
    submap_keyframes: int = 24
    #: Odometry's standard deviation: at rest, per m driven, per rad turned.
    odometry_floor_m: float = 0.03
    odometry_m_per_m: float = 0.25
    odometry_m_per_rad: float = 0.1
    odometry_floor_rad: float = 0.02
    odometry_rad_per_rad: float = 0.4
    odometry_rad_per_m: float = 0.1
    #: Less than this share of the scan on the submap: look around for a better pose. A scan that turned into what is
    #: nearly as good a place has two thirds on it.
    rescue_below: float = 0.75
    #: Less than this: the drift is more than odometry alone tells.
    poor_below: float = 0.55
    #: Less than this: the scan says nothing, odometry is believed.
    lost_below: float = 0.25
    #: Scans that say nothing are not mapped until the robot is so far (m, rad) from the last keyframe: a laser that was
    #: covered for a moment leaves nothing behind. From there the map goes on at the pose that odometry gives.
    lost_keyframe_m: float = 1.0
    lost_keyframe_rad: float = 1.0
    #: How far loops are looked for, and how much farther per m driven since the place was last seen; at most.
    loop_window_m: float = 1.0
    loop_window_m_per_m: float = 0.035
    loop_window_max_m: float = 12.0
    #: A loop needs this share of the scan on the old submap ...
    loop_inliers: float = 0.62
    #: ... and, searching, this score of the correlation.
    loop_score: float = 0.55
    #: A loop that would move the robot farther than this is believed when a second one says the same.
    loop_alone_m: float = 0.6
    #: Keyframes kept where the robot passes again and again: per square metre and sector of headings, ...
    keyframes_per_m2: int = 10
    #: ... of which there are so many.
    heading_sectors: int = 4

    def is_far(self, X_KB: Pose2, lost: bool) -> bool:
        """Whether a scan at ``X_KB`` from the last keyframe is the next one; ``lost``: it fits nowhere."""
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
