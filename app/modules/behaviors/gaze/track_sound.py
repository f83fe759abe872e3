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
from typing import Literal

import numpy as np
from numpy.typing import NDArray
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

    def begin(self, given: TrackSoundParameters, now: float) -> TargetChoice:
        """The sound of the desire."""
        return sound_choice(given.sound, given.track, self.settings, now)

    def candidates(self, percepts: SoundSources, X_OB: Pose3) -> list[Candidate]:
        """All sources that sound now, the loudest first in rank."""
        return [] if self.given is None else sound_candidates(percepts, X_OB, self.given.sound, self.settings)


def sound_choice(sound: Sound, track: int | None, settings: TrackSoundSettings, now: float) -> TargetChoice:
    """The choice of the source of number ``track``, the loudest without one."""
    what = "a voice" if sound == "voice" else "a sound"
    wanted = "" if track is None else str(track)
    return TargetChoice(what, wanted, settings.rules(margin=settings.margin_db), now)


def sound_candidates(heard: SoundSources, X_OB: Pose3, sound: Sound, settings: TrackSoundSettings) -> list[Candidate]:
    """All sources that sound now, the loudest first in rank; the robot at ``X_OB`` in odom."""

    def counts(source: SoundSource) -> bool:
        # What has not been judged yet is no voice: NaN is at least nothing.
        return sound == "any" or source.speech >= settings.voice

    def place(source: SoundSource) -> NDArray[np.float64]:
        range_m = source.range_m if math.isfinite(source.range_m) else settings.range_m
        return np.asarray(X_OB.transform(np.array(heard.p_BA) + range_m * np.array(source.direction)))

    sources = [source for source in heard.sources if source.active and counts(source)]
    return [Candidate(str(source.track), place(source), -source.level_db) for source in sources]
