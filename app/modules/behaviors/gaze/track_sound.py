"""TrackSound: turns the eye towards the loudest sound that is located.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ TrackSound  in   sources           SoundSources, any rate, directions in base_link's axes │
    │             in   joints, odometry  as of every GazeBehavior                              │
    │             out  command           JointCommand of the group (rad), 10 Hz while it tracks │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

The head keeps to one source until another is louder by ``margin_db``, or until it has been silent for ``keep_s``. A
source without a known distance is taken to be ``range_m`` away: of a direction, little depends on it.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.base.geometry import Pose3
from app.messages import SoundSource, SoundSources
from app.modules.behaviors.gaze.target_choice import Candidate, TargetChoice
from app.modules.behaviors.gaze.track_percept import TrackPercept, TrackSettings
from app.runtime.module import ModuleContext

Sound = Literal["voice", "any"]


class TrackSoundSettings(TrackSettings):
    """Settings of TrackSound."""

    margin_db: float = Field(6.0, ge=0, le=60, description="another source must be louder by so much")
    voice: float = Field(0.5, ge=0, le=1, description="a source at least this probably speech is a voice")
    range_m: float = Field(2.0, gt=0, le=20, description="distance of a source whose own is not known")


class TrackSoundParameters(BaseModel, extra="forbid", title="Track a sound"):
    """Parameters of a desire of class TrackSound."""

    sound: Sound = Field("voice", title="Sound", description="voice: people who talk; any: whatever is loudest.")
    track: int | None = Field(
        None, ge=0, title="Track", description="Number of the source, as the page shows it; none: the loudest."
    )


TRACK_SOUND = DesireClass(
    name="TrackSound",
    title="Track a sound",
    description="Turn the camera towards the loudest voice, or the loudest sound.",
    parameters=TrackSoundParameters,
)


class TrackSound(TrackPercept[TrackSoundParameters, SoundSources]):
    """Tracks a sound."""

    title = "Track a sound"
    desire_class = TRACK_SOUND
    Settings = TrackSoundSettings
    settings: TrackSoundSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context, "sources", SoundSources)

    def begin(self, now: float) -> TargetChoice | None:
        """The sound of the desire."""
        given = self.given
        if given is None:
            return None
        what = "a voice" if given.sound == "voice" else "a sound"
        wanted = "" if given.track is None else str(given.track)
        return TargetChoice(what, wanted, self.rules(margin=self.settings.margin_db), now)

    def candidates(self, percepts: SoundSources, X_OB: Pose3) -> list[Candidate]:
        """All sources that sound now, the loudest first in rank."""
        heard = [source for source in percepts.sources if source.active and self._counts(source)]
        return [
            Candidate(str(s.track), np.asarray(X_OB.transform(self._place_of(s, percepts.p_BA))), -s.level_db)
            for s in heard
        ]

    def _counts(self, source: SoundSource) -> bool:
        # What has not been judged yet is no voice: NaN is at least nothing.
        return self.given is not None and (self.given.sound == "any" or source.speech >= self.settings.voice)

    def _place_of(self, source: SoundSource, p_BA: tuple[float, float, float]) -> np.ndarray[Any, np.dtype[np.float64]]:
        range_m = source.range_m if math.isfinite(source.range_m) else self.settings.range_m
        return np.array(p_BA) + range_m * np.array(source.direction)
