"""LookAround: sweeps the gaze over what is around, with a pause at each direction.

    ┌──────────────────────────────────────────────────────────────────────────────────────┐
    │ LookAround  in   joints, odometry  as of every GazeBehavior                          │
    │             out  command           JointCommand of the group (rad), 10 Hz            │
    │             out  accomplishments   Accomplishment, after its rounds                  │
    └──────────────────────────────────────────────────────────────────────────────────────┘

A camera's picture is sharp, and a perception thinned by attention gets one, only while the head stands: so it stops.
A direction counts as reached once the joints are where they were commanded, also where that is short of it.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.modules.behaviors.gaze.gaze_behavior import GazeBehavior, GazeSettings, Look
from app.modules.behaviors.gaze.sweep import Sweep, directions
from app.runtime.module import ModuleContext

#: Joints this near (rad) to their positions have reached them.
_REACHED_RAD = math.radians(1)
#: Distance (m) from the eye of the points that directions are turned into: the eye itself moves by centimetres.
_FAR_M = 100.0


class LookAroundSettings(GazeSettings):
    """Settings of LookAround."""

    step_deg: float = Field(45, gt=0, le=180, description="greatest angle between two directions of a row")
    elevations_deg: tuple[float, ...] = Field(
        (0.0, -17.0), min_length=1, description="of the rows, up positive; odd rows are swept back the other way"
    )


class LookAroundParameters(BaseModel):
    """Parameters of a desire of class LookAround."""

    model_config = ConfigDict(extra="forbid", title="Look around", allow_inf_nan=False)

    width_deg: float = Field(180, ge=0, le=360, title="Width", description="Degrees to look over, half to either side.")
    pause_s: float = Field(1.0, ge=0, le=60, title="Pause", description="Seconds to look into each direction.")
    rounds: int | None = Field(
        None, ge=1, le=1000, title="Rounds", description="How often; none: until the desire is removed."
    )


LOOK_AROUND = DesireClass(
    name="LookAround",
    title="Look around",
    description="Sweep the gaze over what is around, with a pause at each direction.",
    parameters=LookAroundParameters,
    achievement=True,
)


class LookAround(GazeBehavior[LookAroundParameters]):
    """Sweeps the gaze."""

    title = "Look around"
    desire_class = LOOK_AROUND
    Settings = LookAroundSettings
    settings: LookAroundSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._sweep: Sweep | None = None

    def rest(self) -> None:
        """The next sweep begins at its first direction."""
        self._sweep = None

    def look(self, now: float) -> Look:
        """A point far off in the direction of the sweep."""
        given = self.given
        if given is None:
            return Look(None)
        if self._sweep is None:
            rows = [math.radians(elevation) for elevation in self.settings.elevations_deg]
            stops = directions(math.radians(given.width_deg), math.radians(self.settings.step_deg), rows)
            self._sweep = Sweep(stops, given.pause_s)
            bearing, elevation = self._sweep.step(now, reached=False)
        elif given.rounds is not None and self._sweep.round >= given.rounds:
            return Look(None, "it has looked around", outcome="done")
        else:
            bearing, elevation = self._sweep.step(now, self.aim_error_rad < _REACHED_RAD)
        ahead = math.cos(elevation)
        v_B = np.array([ahead * math.cos(bearing), ahead * math.sin(bearing), math.sin(elevation)])
        return Look(self.p_BE + _FAR_M * v_B, as_near=True)
