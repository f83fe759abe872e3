"""LookWhereGoing: while the robot drives, looks down at the floor where it will be in a while.

    ┌──────────────────────────────────────────────────────────────────────────────────────────────┐
    │ LookWhereGoing  in   base              Exploitation of the base: who drives, and how fast    │
    │                 in   path              PlannedPath on the map, of what plans paths           │
    │                 in   localization      Localization, X_MO: where that path is                │
    │                 in   joints, odometry  as of every GazeBehavior                              │
    │                 out  command           JointCommand of the group (rad), 10 Hz while it drives│
    └──────────────────────────────────────────────────────────────────────────────────────────────┘

A level camera sees the floor only from some metres on: what is low and near is found too late or never. The point is on
the path while its behavior drives, else on the arc of the base's twist. While the base stands or backs, the head is
left to others.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from app.attention.desires import DesireClass, NoParameters
from app.base.geometry import Pose2
from app.messages import Exploitation, Localization, PlannedPath
from app.modules.behaviors.gaze.gaze_behavior import GazeBehavior, GazeSettings, Look
from app.modules.behaviors.gaze.look_ahead import ahead_on_arc, ahead_on_path
from app.modules.behaviors.gaze.look_at import LOCALIZED
from app.runtime.module import Caution, ModuleContext

#: Slower than this (m/s, rad/s) the base stands.
_STANDS = 0.02
#: Greatest age (s) of the arbiter's report.
_FRESH_S = 0.5

LOOK_WHERE_GOING = DesireClass(
    name="LookWhereGoing",
    title="Look where it goes",
    description="While the robot drives, look down at the floor ahead of it.",
)


class LookWhereGoingSettings(GazeSettings):
    """Settings of LookWhereGoing."""

    ahead_s: float = Field(2.0, gt=0, le=10, description="time ahead of the point looked at")
    least_m: float = Field(1.0, gt=0, le=10, description="... which is no nearer than this along the way")
    widest_deg: float = Field(50, gt=0, le=180, description="no further aside than this, whatever the path does")
    linger_s: float = Field(1.0, ge=0, le=60, description="the base stands for so long before the head is left")
    path_behavior: str = Field("PlanAndFollowPath", description="the behavior that drives along `path`")


class LookWhereGoing(GazeBehavior[NoParameters]):
    """Looks at the floor ahead while the base moves."""

    title = "Look where it goes"
    desire_class = LOOK_WHERE_GOING
    Settings = LookWhereGoingSettings
    settings: LookWhereGoingSettings
    auxiliary_inputs = frozenset({"path", "localization"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.base = self.input("base", Exploitation, always_open=True, rests=True)
        self.path = self.input("path", PlannedPath, wants="never")
        self.localization = self.input("localization", Localization, wants="never", rests=True)
        self.on(self.base, self._take_exploitation)
        self.on(self.path, self._take_path)
        self.on(self.localization, self._take_localization)
        self._driven: Exploitation | None = None
        self._moved = -math.inf
        self._path: NDArray[np.float64] = np.empty((0, 2))
        self._X_MO: Pose2 | None = None

    async def _take_exploitation(self, exploitation: Exploitation) -> None:
        self._driven = exploitation
        if _moves(exploitation):
            self._moved = exploitation.stamp

    async def _take_path(self, path: PlannedPath) -> None:
        self._path = path.poses[:, :2]

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO if localization.state in LOCALIZED else None

    def cautions(self) -> tuple[Caution, ...]:
        """None for its reports: there is no end to it."""
        return ()

    def look(self, now: float) -> Look:
        """The point on the floor; none while the base stands."""
        driven = self._driven
        if driven is None or now - driven.stamp > _FRESH_S or now - self._moved > self.settings.linger_s:
            return Look(None)
        if driven.twist.linear_mps < -_STANDS:
            return Look(None, "it backs: what is behind the robot is out of reach")
        p_B = self._ahead(driven)
        bearing, distance = math.atan2(p_B[1], p_B[0]), math.hypot(*p_B)
        widest = math.radians(self.settings.widest_deg)
        bearing = max(-widest, min(widest, bearing))
        p_BP = np.array([distance * math.cos(bearing), distance * math.sin(bearing), 0.0])
        return Look(p_BP, as_near=True, in_front=True)

    def _ahead(self, driven: Exploitation) -> NDArray[np.float64]:
        twist, settings = driven.twist, self.settings
        if driven.behavior == settings.path_behavior and self.X_OB is not None and self._X_MO is not None:
            distance_m = max(settings.least_m, abs(twist.linear_mps) * settings.ahead_s)
            point = ahead_on_path(self._path, self._X_MO @ self.X_OB, distance_m)
            # At the end of a path, its end may be under the robot: then there is no direction in it.
            if point is not None and math.hypot(*point) > settings.least_m / 2:
                return point
        return ahead_on_arc(twist.linear_mps, twist.angular_radps, settings.ahead_s, settings.least_m)


def _moves(exploitation: Exploitation) -> bool:
    twist = exploitation.twist
    return max(abs(twist.linear_mps), abs(twist.angular_radps)) > _STANDS
