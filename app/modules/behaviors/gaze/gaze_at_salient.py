"""GazeAtSalient: looks at what stands out, a while each.

    ┌───────────────────────────────────────────────────────────────────────────────────────────────────┐
    │ GazeAtSalient  in   regions           SalientRegions, 5 Hz, directions in base_link's axes        │
    │                in   joints, odometry  as of every GazeBehavior                                    │
    │                out  command           JointCommand of the group (rad), 10 Hz while there is any   │
    │                out  fixations         Fixation, when a region was looked at for long enough       │
    └───────────────────────────────────────────────────────────────────────────────────────────────────┘

The most salient region is followed until the eye has looked at it for ``hold_s``. Then a fixation is published, by
which the ego-sphere inhibits it, and the most salient region after that is next. One that the head cannot look at is
held for no longer. While nothing stands out, the head is left to others.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from app.attention.desires import DesireClass
from app.base.geometry import Pose2, azimuth_elevation, unit_vector
from app.messages import Fixation, SalientRegion, SalientRegions
from app.modules.behaviors.gaze.fixation import FixationRules, Gazing
from app.modules.behaviors.gaze.gaze_behavior import GazeBehavior, GazeSettings, Look
from app.modules.saliency_gains import SaliencyGains
from app.runtime.module import Caution, ModuleContext

#: The head looks at its point up to this angle (rad).
_REACHED_RAD = math.radians(3)


class GazeAtSalientSettings(GazeSettings):
    """Settings of GazeAtSalient."""

    hold_s: float = Field(1.5, gt=0, le=60, description="so long each region is looked at")
    reach_s: float = Field(2.0, gt=0, le=60, description="so long the head takes to a region at most")
    same_deg: float = Field(15.0, gt=0, le=90, description="a region that moves less in a message is the same")
    range_m: float = Field(2.5, gt=0, le=50, description="taken distance of regions")


LOOK_AT_SALIENT = DesireClass(
    name="LookAtSalient",
    title="Look at what stands out",
    description="Turn the camera to what moves, sounds, is coloured or has a face, a while each.",
    parameters=SaliencyGains,
)


class GazeAtSalient(GazeBehavior[SaliencyGains]):
    """Looks at what stands out."""

    title = "Gaze at what stands out"
    desire_class = LOOK_AT_SALIENT
    Settings = GazeAtSalientSettings
    settings: GazeAtSalientSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.regions = self.input("regions", SalientRegions, capacity=4, wants="if_wanted")
        self.fixations = self.output("fixations", Fixation)
        self.on(self.regions, self._take_regions)
        self._newest: SalientRegions | None = None
        self._taken = -math.inf
        self._gazing = self._initial_gazing()

    def cautions(self) -> tuple[Caution, ...]:
        """None for its reports: there is no end to it."""
        return ()

    def rest(self) -> None:
        """The next gaze begins with the regions of its time."""
        self._newest = None
        self._gazing = self._initial_gazing()

    def look(self, now: float) -> Look:
        """The region that is looked at, where the robot is now."""
        if self.given is None or self.X_OB is None:
            return Look(None)
        self._place()
        reached = self.aim_error_rad < _REACHED_RAD
        if (v_O := self._gazing.step(now, reached)) is not None:
            azimuth, elevation = azimuth_elevation(v_O)
            self.fixations.publish(Fixation(now, azimuth - self.X_OB.theta, elevation))
        if self._gazing.v_O is None:
            return Look(None, "it waits: nothing stands out")
        v_B = self.X_OB.to_pose3().rotation.T @ self._gazing.v_O
        return Look(self._p_BH() + self.settings.range_m * v_B, as_near=True)

    async def _take_regions(self, regions: SalientRegions) -> None:
        self._newest = regions

    def _place(self) -> None:
        """Hand over the newest regions once odometry has reached their stamp."""
        newest = self._newest
        if newest is None or newest.stamp <= self._taken or (X_OB := self.poses.at(newest.stamp)) is None:
            return
        self._taken = newest.stamp
        self._gazing.take(newest.stamp, [_direction(region, X_OB) for region in newest.regions])

    def _p_BH(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return np.array((0.0, 0.0, 0.0) if self._newest is None else self._newest.p_BH)

    def _initial_gazing(self) -> Gazing:
        s = self.settings
        return Gazing(FixationRules(s.hold_s, s.reach_s, math.radians(s.same_deg)))


def _direction(region: SalientRegion, X_OB: Pose2) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.asarray(unit_vector(region.azimuth + X_OB.theta, region.elevation))
