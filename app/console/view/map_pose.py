"""Where the scene, which is odometry's, lays the map."""

from __future__ import annotations

import math

from app.base.geometry import Pose2
from app.messages import Localization

#: A change of X_MO by more than this is no drift that is being corrected, but a loop that was closed.
JUMP_M = 0.1
JUMP_RAD = 0.04
#: A map that has not followed such a jump after this long (s) will not.
PATIENCE_S = 5.0


class MapPose:
    """Gives X_OM, the map's pose in the scene, which itself does not move when the robot's place on the map jumps.

    When a loop is closed while the map grows, the pose jumps at once and the picture of the map follows: until it does,
    the picture there is stays where it fits what the laser sees.
    """

    def __init__(self) -> None:
        self._last: Localization | None = None
        #: What the map that is shown was drawn by, and when it was outdated.
        self._held: Pose2 | None = None
        self._jumped = 0.0

    def take(self, localization: Localization) -> None:
        """Take the robot's place on the map; the same message may come again."""
        before, self._last = self._last, localization
        if before is localization:
            return
        if before is None or before.map != localization.map or localization.state != "mapping":
            self._held = None
        elif before.state == "mapping" and _jumps(before.X_MO, localization.X_MO):
            self._held = self._held or before.X_MO
            self._jumped = localization.stamp

    def at(self, map_stamp: float) -> Pose2 | None:
        """X_OM for the map as it was at ``map_stamp`` (s); None while the robot has no place on the map."""
        if self._last is None:
            return None
        if self._held is not None and not (map_stamp < self._jumped and self._last.stamp - self._jumped < PATIENCE_S):
            self._held = None
        return (self._held or self._last.X_MO).inverse()


def _jumps(before: Pose2, now: Pose2) -> bool:
    turn = abs(math.remainder(now.theta - before.theta, math.tau))
    return math.hypot(now.x - before.x, now.y - before.y) > JUMP_M or turn > JUMP_RAD
