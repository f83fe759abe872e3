"""LookAt: turns the head so that a camera looks at a point, a place that the robot knows, a face or a sound.

    ┌───────────────────────────────────────────────────────────────────────────────────────────────┐
    │ LookAt    in   joints, odometry  as of every GazeBehavior                                     │
    │           in   localization      Localization, X_MO on the map: for points on the map         │
    │           in   landmarks         Landmarks, in odom or map: for places by name                │
    │           in   faces             Faces, any rate: for faces; may be absent                    │
    │           in   sources           SoundSources, any rate: for sounds; may be absent            │
    │           out  command           JointCommand of the group (rad), 10 Hz while there is a point│
    │           out  accomplishments   Accomplishment, when the eye looks at the point              │
    │           writes desires of the classes LocateFaces and LocateVoices                          │
    └───────────────────────────────────────────────────────────────────────────────────────────────┘

The point comes with the desire LookAt: in ``base_link`` it turns with the robot; in ``odom`` or ``map`` the head
follows it while the robot drives, so the desire stays once it is accomplished. A place is the text of a QR code that
was found. Faces and sounds are followed as TrackFace and TrackSound do; while one is asked for, and attention lets it
look, LookAt itself desires the perception.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.attention.desires import DesireClass
from app.base.geometry import Pose2, Pose3
from app.maps.zones import FURTHEST_M
from app.messages import Faces, Landmarks, Localization, SoundSources
from app.modules.behaviors.gaze.gaze_behavior import GazeBehavior, Look
from app.modules.behaviors.gaze.percept_follower import PerceptFollower
from app.modules.behaviors.gaze.target_choice import Candidate
from app.modules.behaviors.gaze.track_object import face_candidates, face_choice
from app.modules.behaviors.gaze.track_sound import Sound, TrackSoundSettings, sound_candidates, sound_choice
from app.modules.behaviors.wanted_perception import WantedPerception
from app.runtime.module import ModuleContext

Frame = Literal["base_link", "odom", "map"]

#: Classes of the desires for what finds faces and sounds.
LOCATE_FACES, LOCATE_VOICES = "LocateFaces", "LocateVoices"
#: States of localization whose pose is good enough to aim by.
LOCALIZED = ("mapping", "tracking")


class LookAtParameters(BaseModel):
    """Parameters of a desire of class LookAt: a point, a place, a face or a sound."""

    model_config = ConfigDict(extra="forbid", title="Look at something", allow_inf_nan=False)

    x: float | None = Field(
        None, ge=-FURTHEST_M, le=FURTHEST_M, title="x", description="The point, in metres in its frame."
    )
    y: float | None = Field(
        None, ge=-FURTHEST_M, le=FURTHEST_M, title="y", description="The point, in metres in its frame."
    )
    z: float = Field(1.2, ge=-100, le=100, title="z", description="Its height, in metres above the floor.")
    frame: Frame = Field(
        "odom", title="Frame", description="base_link: it turns with the robot; odom or map: it stays in the room."
    )
    place: str | None = Field(
        None, min_length=1, max_length=500, title="Place", description="Instead of a point: the text of a code found."
    )
    face: bool = Field(False, title="Face", description="Instead of a point: a face, the nearest or that of `track`.")
    sound: Sound | None = Field(
        None,
        title="Sound",
        description="Instead of a point: the loudest voice, or the loudest of any sounds, or that of `track`.",
    )
    track: int | None = Field(
        None, ge=0, title="Track", description="Number of the face or of the sound, as the page shows it."
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        point = (self.x is not None) + (self.y is not None)
        others = (self.place is not None) + self.face + (self.sound is not None)
        if (point, others) not in ((2, 0), (0, 1)):
            raise ValueError("needs one of: x and y, a place, a face, a sound")
        if self.track is not None and not self.face and self.sound is None:
            raise ValueError("a track is of a face or of a sound")
        return self


LOOK_AT = DesireClass(
    name="LookAt",
    title="Look at something",
    description="Turn the head so that the camera looks at a point, a place that was found, a face or a sound, "
    "as long as it is desired.",
    parameters=LookAtParameters,
)


@dataclass(frozen=True, slots=True)
class PointOfInterest:
    """A point ``p_FP`` (3,) m in ``frame``."""

    p_FP: NDArray[np.float64]
    frame: Frame

    def in_base(self, X_OB: Pose2 | None, X_MO: Pose2 | None) -> NDArray[np.float64] | None:
        """``p_BP`` (3,) for the robot at ``X_OB`` in odom, odom at ``X_MO`` on the map; None where its frame is not
        known."""
        if self.frame == "base_link":
            return self.p_FP
        if X_OB is None or (self.frame == "map" and X_MO is None):
            return None
        X_FB = X_MO @ X_OB if self.frame == "map" and X_MO is not None else X_OB
        return np.asarray(X_FB.to_pose3().inverse().transform(self.p_FP))


class LookAt(GazeBehavior[LookAtParameters]):
    """Looks with the joints of the head at what is desired."""

    title = "Look at"
    desire_class = LOOK_AT
    Settings = TrackSoundSettings
    settings: TrackSoundSettings
    auxiliary_inputs = frozenset({"localization", "landmarks", "faces", "sources"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.localization = self.input("localization", Localization, rests=True)
        self.landmarks = self.input("landmarks", Landmarks, wants="never")
        self.faces = self.input("faces", Faces, capacity=8, wants="if_wanted")
        self.sources = self.input("sources", SoundSources, capacity=8, wants="if_wanted")
        self._X_MO: Pose2 | None = None
        self._places: dict[str, PointOfInterest] = {}
        self._seen: PerceptFollower[Faces] = PerceptFollower(self.poses, face_candidates)
        self._heard: PerceptFollower[SoundSources] = PerceptFollower(self.poses, self._sounds)
        self._perception = WantedPerception(self)
        self.on(self.localization, self._take_localization)
        self.on(self.landmarks, self._take_landmarks)
        self.on(self.faces, self._seen.take)
        self.on(self.sources, self._heard.take)
        self.every(self.settings.period_s, self._want_perception)

    async def start(self) -> None:
        """Read the body's model, and the landmarks known already. Raises ModuleFailed as GazeBehavior does."""
        await super().start()
        if self.landmarks.channel is not None and self.landmarks.channel.latest is not None:
            self._take_landmarks(self.landmarks.channel.latest)

    async def stop(self) -> None:
        """Withdraw the desire for a perception."""
        self._perception.want(None, LOOK_AT.name)

    def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO if localization.state in LOCALIZED else None

    def _take_landmarks(self, message: Landmarks) -> None:
        frame: Frame = "map" if message.frame == "map" else "odom"
        self._places = {mark.text: PointOfInterest(np.array(mark.p_FQ), frame) for mark in message.landmarks}

    def _sounds(self, heard: SoundSources, X_OB: Pose3) -> list[Candidate]:
        given = self.given
        return [] if given is None or given.sound is None else sound_candidates(heard, X_OB, given.sound, self.settings)

    def _want_perception(self) -> None:
        given = self.given if self.command.wanted else None
        wanted = None
        if given is not None and given.face and self.faces.connected:
            wanted = LOCATE_FACES
        elif given is not None and given.sound is not None and self.sources.connected:
            wanted = LOCATE_VOICES
        self._perception.want(wanted, LOOK_AT.name)

    def rest(self) -> None:
        """The next track begins with the percepts of its time."""
        self._seen.rest()
        self._heard.rest()

    def look(self, now: float) -> Look:
        """What the desire asks for, where the robot is now."""
        given = self.given
        if given is None:
            return Look(None)
        if given.face:
            if not self.faces.connected:
                return Look(None, "this program does not look for faces", outcome="failed")
            return self._seen.look(now, self.X_OB, lambda: face_choice(given.track, self.settings.rules(), now))
        if (sound := given.sound) is not None:
            if not self.sources.connected:
                return Look(None, "this program does not listen for sounds", outcome="failed")
            return self._heard.look(now, self.X_OB, lambda: sound_choice(sound, given.track, self.settings, now))
        return self._look_at_point(given)

    def _look_at_point(self, given: LookAtParameters) -> Look:
        if given.place is not None:
            place = self._places.get(given.place)
            if place is None:
                return Look(None, f"it waits: no code that was found says {given.place!r}")
            point = place
        else:
            point = PointOfInterest(np.array([given.x, given.y, given.z], np.float64), given.frame)
        p_BP = point.in_base(self.X_OB, self._X_MO)
        if p_BP is None:
            return Look(None, f"it waits: where the robot is in {point.frame} is not known")
        return Look(p_BP)
