"""Face: shows expressions with the joints of the face, blinks, looks, speaks and reacts.

    ┌───────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Face    in   joints    JointState, 30 Hz; never filtered                                      │
    │         in   gaze      JointCommand of the head, as LookAt gives it; may be absent            │
    │         in   speech    Speech: the mouth; may be absent                                       │
    │         in   voice     Audio: the voice of an operator who talks through it; may be absent    │
    │         in   heard     Exploitation of the voice: whether that is played; may be absent       │
    │         in   faces     Faces: a new one is a detection, the nearest is looked at; may be absent│
    │         in   codes     QRCodes: a new one is a detection; may be absent                       │
    │         in   noises    LoudNoise: each is a detection; may be absent                          │
    │         in   events    PerceptEvent: those of ``reacts_to`` that appear; may be absent        │
    │         out  command   JointCommand of the face (rad), while an expression is desired         │
    │         out  calm      JointCommand of the face (rad), else                                   │
    └───────────────────────────────────────────────────────────────────────────────────────────────┘

Commands come 30 times a second while the face moves, else ten times. No input wants its channel: no perception is kept
awake for the face.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.base.kinematic_model import load_model
from app.messages import (
    Audio,
    Exploitation,
    Faces,
    JointCommand,
    JointState,
    LoudNoise,
    PerceptEvent,
    QRCodes,
    Speech,
)
from app.modules.behaviors.face.animation import FaceAnimation, FaceState, Novelty
from app.modules.behaviors.face.expression import CALM, EXPRESSIONS, JOINTS, Expression
from app.modules.behaviors.face.gaze import EyeGaze
from app.modules.behaviors.face.voice_mouth import VoiceMouth
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

PERIOD_S = 1 / 30
_RENEWED_S = 0.1
"""A pose that stays is commanded again so often: the guard takes an old command for none."""
_STILL_RAD = 1e-3
_GAZE_FRESH_S = 0.5
_FACE_FRESH_S = 1.0
_SPEECH_FRESH_S = 1.5
"""A mouth that is given no new shape for so long is closed: the speaking module has failed."""


class FaceSettings(Settings):
    """Settings of Face."""

    group: str = Field("face", min_length=1, description="actuator group of the face's joints")
    reaction: bool = Field(True, description="a small movement at once on every detection")
    reacts_to: frozenset[str] = Field(
        frozenset({"dark", "voice"}), description="kinds of percept events that are detections, too"
    )
    look_at_faces: bool = Field(True, description="the eyes look at the nearest face while nothing else is looked at")
    operator: str = Field("Operator", min_length=1, description="name of the operator's voice at the loudspeaker")
    seed: int = Field(1, description="of the random intervals between blinks")


class ExpressParameters(BaseModel):
    """Parameters of a desire of class Express."""

    model_config = ConfigDict(extra="forbid", title="Express", allow_inf_nan=False)

    expression: Literal["calm", "attractive", "happy", "sad", "angry"] = Field(
        "calm", title="Expression", description="What to express, if no weight below is over 0."
    )
    attractive: float = Field(0.0, ge=0, le=1, title="Attractive", description="Weight of it in a blend, 0 to 1.")
    happy: float = Field(0.0, ge=0, le=1, title="Happy", description="Weight of it in a blend, 0 to 1.")
    sad: float = Field(0.0, ge=0, le=1, title="Sad", description="Weight of it in a blend, 0 to 1.")
    angry: float = Field(0.0, ge=0, le=1, title="Angry", description="Weight of it in a blend, 0 to 1.")
    strength: float = Field(1.0, ge=0, le=1, title="Strength", description="0 is the calm face, 1 all of it.")

    def weights(self) -> dict[Expression, float]:
        """The weight of each expression, their sum at most 1."""
        blend: dict[Expression, float] = {name: getattr(self, name) for name in EXPRESSIONS}
        total = sum(blend.values())
        if total == 0:
            blend = {name: float(name == self.expression) for name in EXPRESSIONS}
        return {name: self.strength * weight / max(1.0, total) for name, weight in blend.items()}


EXPRESS = DesireClass(
    name="Express",
    title="Express a feeling",
    description="Show an expression, or a blend of several, on the face.",
    parameters=ExpressParameters,
)


class Face(Module):
    """Shows what is desired on the face; without a desire, a calm one."""

    title = "Face"
    desire_classes = (EXPRESS,)
    Settings = FaceSettings
    settings: FaceSettings
    auxiliary_inputs = frozenset({"gaze", "speech", "voice", "heard", "faces", "codes", "noises", "events"})

    _animation: FaceAnimation
    _gaze: EyeGaze

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.joints = self.input("joints", JointState, always_open=True)
        self.gaze = self.input("gaze", JointCommand, wants="never")
        self.speech = self.input("speech", Speech, wants="never")
        # A fifth of a second of the shortest frames that a page sends.
        self.voice = self.input("voice", Audio, capacity=20, wants="never")
        self.heard = self.input("heard", Exploitation, wants="never")
        self.faces = self.input("faces", Faces, wants="never")
        self.codes = self.input("codes", QRCodes, wants="never")
        self.noises = self.input("noises", LoudNoise, wants="never")
        self.events = self.input("events", PerceptEvent, capacity=8, wants="never")
        self.command = self.output("command", JointCommand)
        self.calm = self.output("calm", JointCommand)
        self.on(self.joints, self._take_joints)
        self.on(self.gaze, self._take_gaze)
        self.on(self.speech, self._take_speech)
        self.on(self.voice, self._take_voice)
        self.on(self.heard, self._take_heard)
        self.on(self.faces, self._take_faces)
        self.on(self.codes, self._take_codes)
        self.on(self.noises, self._take_noise)
        self.on(self.events, self._take_event)
        self.every(PERIOD_S, self._beat)
        self._weights: Mapping[Expression, float] | None = None
        self._measured: Mapping[str, float] = {}
        self._goal: JointCommand | None = None
        self._said: Speech | None = None
        self._mouth = VoiceMouth()
        self._heard: str | None = None
        self._nearest: tuple[float, tuple[float, float, float]] | None = None
        self._known_faces, self._known_codes = Novelty(), Novelty()
        self._detected: float | None = None
        self._given = CALM
        self._given_at = float("-inf")

    async def start(self) -> None:
        """Read the body's model. Raises ModuleFailed for a body without such a face."""
        body = robot_link(self).description
        group = body.groups.get(self.settings.group)
        if group is None:
            raise ModuleFailed(f"{self.name} moves the group {self.settings.group!r}, which {body.name} does not have")
        limits = {joint.name: joint for joint in group.joints}
        if missing := [name for name in JOINTS if name not in limits]:
            raise ModuleFailed(
                f"{self.name} needs the joint {missing[0]!r} in the group {group.name!r} of {body.name}, which has "
                f"{', '.join(limits)}"
            )
        try:
            model = await self.compute(load_model, body.model_path)
        except ConfigError as failure:
            raise ModuleFailed(str(failure)) from None
        self._gaze = EyeGaze(model, model.joints["eyes_tilt_joint"])
        self._animation = FaceAnimation([limits[name] for name in JOINTS], self.settings.seed)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the expression from the desire; without ``strength`` there is none."""
        if "strength" not in parameters:
            self._weights = None
            return
        given = {key: parameters[key] for key in ExpressParameters.model_fields if key in parameters}
        self._weights = ExpressParameters.model_validate(given).weights()

    def _take_joints(self, joints: JointState) -> None:
        self._measured = dict(zip(joints.names, joints.positions, strict=True))

    def _take_gaze(self, command: JointCommand) -> None:
        self._goal = command

    def _take_speech(self, speech: Speech) -> None:
        self._said = speech

    def _take_voice(self, voice: Audio) -> None:
        self._mouth.take(voice.samples, voice.rate, self.clock.now())

    def _take_heard(self, report: Exploitation) -> None:
        self._heard = report.behavior

    def _take_faces(self, seen: Faces) -> None:
        if self._known_faces.any_new((face.track for face in seen.faces), seen.stamp):
            self._detect()
        if seen.faces:
            nearest = min(seen.faces, key=lambda face: face.range_m)
            self._nearest = seen.stamp, nearest.p_BF

    def _take_codes(self, seen: QRCodes) -> None:
        if self._known_codes.any_new((code.text for code in seen.codes), seen.stamp):
            self._detect()

    def _take_noise(self, _: LoudNoise) -> None:
        self._detect()

    def _take_event(self, event: PerceptEvent) -> None:
        if event.kind in self.settings.reacts_to and event.name == f"{event.kind}.appears":
            self._detect()

    def _detect(self) -> None:
        if self.settings.reaction:
            self._detected = self.clock.now()

    def _beat(self) -> None:
        now = self.clock.now()
        pose = self._animation.step(
            FaceState(now, self._weights or {}, self._eyes(now), self._viseme(now), self._detected)
        )
        if now - self._given_at < _RENEWED_S - 0.5 * PERIOD_S and np.abs(pose - self._given).max() < _STILL_RAD:
            return
        self._given, self._given_at = pose, now
        command = JointCommand(now, self.settings.group, JOINTS, tuple(pose.tolist()))
        expressing = self._weights is not None and self.command.filter.is_open
        (self.command if expressing else self.calm).publish(command)

    def _eyes(self, now: float) -> tuple[float, float] | None:
        goal, nearest = self._goal, self._nearest
        if goal is not None and now - goal.stamp < _GAZE_FRESH_S:
            return self._gaze.to_goal(dict(zip(goal.names, goal.positions, strict=True)), self._measured)
        if self.settings.look_at_faces and nearest is not None and now - nearest[0] < _FACE_FRESH_S:
            return self._gaze.to_point(np.array(nearest[1]), self._measured)
        return None

    def _viseme(self, now: float) -> str | None:
        operator = self._mouth.viseme(now)
        if operator is not None and (not self.heard.connected or self._heard == self.settings.operator):
            return operator
        said = self._said
        if said is None or said.state != "speaking" or now - said.stamp > _SPEECH_FRESH_S:
            return None
        return said.viseme
