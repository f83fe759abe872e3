"""LookAt: turns the head so that a camera looks at a point, or at a place that the robot knows.

    ┌───────────────────────────────────────────────────────────────────────────────────────────────┐
    │ LookAt    in   joints, odometry  as of every GazeBehavior                                     │
    │           in   localization      Localization, X_MO on the map: for points on the map         │
    │           in   landmarks         Landmarks, in odom or map: for places by name                │
    │           out  command           JointCommand of the group (rad), 10 Hz while there is a point│
    │           out  accomplishments   Accomplishment, when the eye looks at the point              │
    └───────────────────────────────────────────────────────────────────────────────────────────────┘

The point comes with the desire LookAt: in ``base_link`` it turns with the robot; in ``odom`` or ``map`` the head
follows it while the robot drives, so the desire stays once it is accomplished. A place is the text of a QR code that
was found.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.attention.desires import DesireClass
from app.base.geometry import Pose2
from app.maps.zones import FURTHEST_M
from app.messages import Landmarks, Localization
from app.modules.behaviors.gaze.gaze_behavior import GazeBehavior, GazeSettings, Look
from app.runtime.module import ModuleContext

Frame = Literal["base_link", "odom", "map"]

#: States of localization whose pose is good enough to aim by.
LOCALIZED = ("mapping", "tracking")


class LookAtParameters(BaseModel):
    """Parameters of a desire of class LookAt: a point, or a place."""

    model_config = ConfigDict(extra="forbid", title="Look at a point", allow_inf_nan=False)

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

    @model_validator(mode="after")
    def _one(self) -> Self:
        point = (self.x is not None) + (self.y is not None)
        if (point, self.place is None) not in ((2, True), (0, False)):
            raise ValueError("needs x and y, or a place, and not both")
        return self


LOOK_AT = DesireClass(
    name="LookAt",
    title="Look at a point",
    description="Turn the head so that the camera looks at a point, or at a place that was found, as long as it is "
    "desired.",
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
    """Looks at a point with the joints of the head."""

    title = "Look at"
    desire_class = LOOK_AT
    Settings = GazeSettings
    auxiliary_inputs = frozenset({"localization", "landmarks"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.localization = self.input("localization", Localization)
        self.landmarks = self.input("landmarks", Landmarks, wants="never")
        self.on(self.localization, self._take_localization)
        self.on(self.landmarks, self._take_landmarks)
        self._X_MO: Pose2 | None = None
        self._places: dict[str, PointOfInterest] = {}

    async def start(self) -> None:
        """Read the body's model, and the landmarks known already. Raises ModuleFailed as GazeBehavior does."""
        await super().start()
        if self.landmarks.channel is not None and self.landmarks.channel.latest is not None:
            await self._take_landmarks(self.landmarks.channel.latest)

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO if localization.state in LOCALIZED else None

    async def _take_landmarks(self, message: Landmarks) -> None:
        frame: Frame = "map" if message.frame == "map" else "odom"
        self._places = {mark.text: PointOfInterest(np.array(mark.p_FQ), frame) for mark in message.landmarks}

    def look(self, now: float) -> Look:
        """The point of the desire, where the robot is now."""
        given = self.given
        if given is None:
            return Look(None)
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
