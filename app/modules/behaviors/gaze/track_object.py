"""TrackFace and TrackCode: keep the eye on a face, or on a QR code, while it or the robot moves.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ TrackFace  in   faces             Faces, any rate, m in base_link at their own stamp     │
    │ TrackCode  in   codes             QRCodes, likewise                                      │
    │ both       in   joints, odometry  as of every GazeBehavior                               │
    │            out  command           JointCommand of the group (rad), 10 Hz while it tracks │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

The nearest is taken unless the desire names one, and kept while it is seen. While it is not, the eye stays on its last
place; after ``give_up_s`` the head is left to others, with the reason in the log, until one is seen again.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.base.geometry import Pose3
from app.messages import Faces, QRCodes
from app.modules.behaviors.gaze.target_choice import Candidate, ChoiceRules, TargetChoice
from app.modules.behaviors.gaze.track_percept import TrackPercept
from app.runtime.module import ModuleContext


class TrackFaceParameters(BaseModel, extra="forbid", title="Track a face"):
    """Parameters of a desire of class TrackFace."""

    track: int | None = Field(
        None, ge=1, title="Track", description="Number of the face, as the page shows it; none: the nearest."
    )


class TrackCodeParameters(BaseModel, extra="forbid", title="Track a QR code"):
    """Parameters of a desire of class TrackCode."""

    text: str | None = Field(
        None, min_length=1, max_length=500, title="Text", description="Of the code; none: the nearest."
    )


TRACK_FACE = DesireClass(
    name="TrackFace",
    title="Track a face",
    description="Keep the camera on a face while it or the robot moves.",
    parameters=TrackFaceParameters,
)
TRACK_CODE = DesireClass(
    name="TrackCode",
    title="Track a QR code",
    description="Keep the camera on a QR code while it or the robot moves.",
    parameters=TrackCodeParameters,
)


class TrackFace(TrackPercept[TrackFaceParameters, Faces]):
    """Tracks a face."""

    title = "Track a face"
    desire_class = TRACK_FACE

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context, "faces", Faces)

    def begin(self, given: TrackFaceParameters, now: float) -> TargetChoice:
        """The face of the desire."""
        return face_choice(given.track, self.settings.rules(), now)

    def candidates(self, percepts: Faces, X_OB: Pose3) -> list[Candidate]:
        """All faces, the nearest first in rank."""
        return face_candidates(percepts, X_OB)


class TrackCode(TrackPercept[TrackCodeParameters, QRCodes]):
    """Tracks a QR code."""

    title = "Track a QR code"
    desire_class = TRACK_CODE

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context, "codes", QRCodes)

    def begin(self, given: TrackCodeParameters, now: float) -> TargetChoice:
        """The code of the desire."""
        wanted = given.text or ""
        return TargetChoice("code" if wanted else "a code", wanted, self.settings.rules(), now)

    def candidates(self, percepts: QRCodes, X_OB: Pose3) -> list[Candidate]:
        """All codes whose place is known, the nearest first in rank."""
        return [_candidate(code.text, code.p_BQ, X_OB) for code in percepts.codes if code.p_BQ is not None]


def face_choice(track: int | None, rules: ChoiceRules, now: float) -> TargetChoice:
    """The choice of the face of number ``track``, the nearest without one."""
    wanted = "" if track is None else str(track)
    return TargetChoice("face" if wanted else "a face", wanted, rules, now)


def face_candidates(faces: Faces, X_OB: Pose3) -> list[Candidate]:
    """All faces, the nearest first in rank; the robot at ``X_OB`` in odom."""
    return [_candidate(str(face.track), face.p_BF, X_OB) for face in faces.faces]


def _candidate(name: str, p_BP: tuple[float, float, float], X_OB: Pose3) -> Candidate:
    return Candidate(name, np.asarray(X_OB.transform(np.array(p_BP))), math.hypot(*p_BP))
