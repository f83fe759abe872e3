"""PerceptEvents: what is perceived appears, leaves and changes (docs/percept-events.md).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ PerceptEvents    in   codes     QRCodes, with each image read; may be absent             │
    │                  in   faces     Faces, with each image looked at; may be absent          │
    │                  in   sources   SoundSources, as they come; may be absent                │
    │                  in   noises    LoudNoise, as they come; may be absent                   │
    │                  in   ...       each Look that configuration names, as they come         │
    │                  in   odometry  Odometry, 100 Hz, X_OB in odom; may be absent            │
    │                  in   divisors  Divisors, on change; may be absent                       │
    │                  out  events    PerceptEvent (m and rad in odom), as they happen         │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

The hysteresis is ``presence.look``. Faces, codes, sound sources and messages whose type declares a ``percept_kind``
(``app.messages.Look``) come with each look, empty where nothing is seen: no message is no look. A loud noise is an
event, and its silence says nothing: quiet counts only while ``divisors`` says that ``noise_filter`` is open. The inputs
of percepts never want their channels: no perception is kept awake for its events.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from app.base.geometry import FloatArray, Pose2, wrap_angle
from app.messages import (
    Divisors,
    Faces,
    Look,
    LoudNoise,
    Message,
    Odometry,
    PerceptEvent,
    PerceptKind,
    QRCodes,
    SoundSources,
)
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.presence import Change, Hysteresis, PresenceState, Sighting, look
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED
from app.runtime.module import Module, ModuleContext, Settings

#: Looks that may wait while the pose at an earlier one's stamp is awaited.
_CAPACITY = 8
_BEAT_S = 0.25
#: A sound's distance is known if its standard deviation is at most this share of it.
_KNOWN = 0.5
#: Kept over restarts, so that what is there does not appear twice.
_PRESENCE = "presence"

DEFAULTS = {
    "code": Hysteresis(sightings=2, off_looks=3, off_s=3.0, moved_m=0.5),
    "face": Hysteresis(sightings=3, off_looks=3, off_s=2.0, moved_m=0.5),
    "voice": Hysteresis(sightings=2, on_s=0.3, off_s=2.0, enter=0.5, stay=0.3, turned_rad=0.5),
    "noise": Hysteresis(off_s=1.0),
}
#: Of the kinds that message types declare.
DECLARED = Hysteresis(sightings=2, off_s=0.5)


class PerceptEventsSettings(Settings):
    """Settings of PerceptEvents: for each kind what differs from its default hysteresis."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Hysteresis] = Field(init=False)

    code: Hysteresis = DEFAULTS["code"]
    face: Hysteresis = DEFAULTS["face"]
    voice: Hysteresis = DEFAULTS["voice"]
    noise: Hysteresis = DEFAULTS["noise"]
    noise_filter: str = Field("LoudNoiseDetector.audio", description="while it is closed, quiet is not heard")

    @model_validator(mode="before")
    @classmethod
    def _over_defaults(cls, values: Any) -> Any:
        if not isinstance(values, dict):
            return values
        return {
            kind: {**DEFAULTS.get(kind, DECLARED).model_dump(), **value} if isinstance(value, dict) else value
            for kind, value in values.items()
        }

    def rule(self, kind: str) -> Hysteresis:
        """The hysteresis of ``kind``."""
        rule: Hysteresis = getattr(self, kind, DECLARED)
        return rule

    @property
    def declared(self) -> frozenset[str]:
        """The kinds named that are none of the module's own."""
        return frozenset(self.__pydantic_extra__)


class PerceptEvents(Module):
    title = "Percept events"
    aids = frozenset({"divisors"})
    Settings = PerceptEventsSettings
    settings: PerceptEventsSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._presence: dict[str, PresenceState] = {}
        self._poses = PoseAt(self.clock)
        self._listening = True
        self._kinds: set[str] = set()
        self.codes = self.input("codes", QRCodes, capacity=_CAPACITY, wants="never")
        self.faces = self.input("faces", Faces, capacity=_CAPACITY, wants="never")
        self.sources = self.input("sources", SoundSources, capacity=_CAPACITY, wants="never")
        self.noises = self.input("noises", LoudNoise, capacity=_CAPACITY, wants="never")
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.divisors = self.input("divisors", Divisors)
        self.events = self.output("events", PerceptEvent)
        self.on(self.codes, self._read)
        self.on(self.faces, self._see)
        self.on(self.sources, self._hear)
        self.on(self.noises, self._startle)
        self.on(self.odometry, self._poses.add)
        self.on(self.divisors, self._learn)
        self.every(_BEAT_S, self._listen)

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any message whose type declares a kind of percept events."""
        kind = getattr(message_type, "percept_kind", None)
        if isinstance(kind, PerceptKind):
            self._kinds.add(kind.name)
            self.on(self.input(name, message_type, capacity=_CAPACITY, wants="never"), self._looker(kind.name))

    def check_wiring(self) -> None:
        """Refuse the hysteresis of a kind that no input brings."""
        if unknown := sorted(self.settings.declared - self._kinds):
            known = ", ".join(sorted({*DEFAULTS, *self._kinds}))
            raise ModuleFailed(f"no input of {self.name} brings percepts of kind {unknown[0]!r}; there are {known}")

    async def start(self) -> None:
        """Go on with what was there before a restart."""
        self._presence = self.persistent.pop(_PRESENCE, {})
        known = None if self.divisors.channel is None else self.divisors.channel.latest
        if known is not None:
            await self._learn(known)

    async def _learn(self, divisors: Divisors) -> None:
        phi = dict(zip(divisors.filters, divisors.divisors, strict=True))
        self._listening = phi.get(self.settings.noise_filter, 1.0) != CLOSED

    async def _read(self, codes: QRCodes) -> None:
        X_OB = await self._pose(codes.stamp, codes.codes)
        self._look("code", codes.frame, codes.stamp, of_codes(codes, X_OB))

    async def _see(self, faces: Faces) -> None:
        X_OB = await self._pose(faces.stamp, faces.faces)
        self._look("face", faces.frame, faces.stamp, of_faces(faces, X_OB))

    async def _hear(self, sounds: SoundSources) -> None:
        X_OB = await self._pose(sounds.stamp, sounds.sources)
        self._look("voice", "sound_sources", sounds.stamp, of_sources(sounds, X_OB))

    async def _startle(self, noise: LoudNoise) -> None:
        self._look("noise", "loud_noises", noise.stamp, [Sighting("")])

    def _looker(self, kind: str) -> Callable[[Any], Awaitable[None]]:
        async def take(message: Look) -> None:
            sightings = [Sighting(subject, confidence) for subject, confidence in message.subjects.items()]
            self._look(kind, message.frame, message.stamp, sightings)

        return take

    async def _listen(self) -> None:
        """A look at no noise: it is quiet now, while the detector listens."""
        if self._listening and self._presence.get("noise", PresenceState()).subjects:
            self._look("noise", "loud_noises", self.clock.now(), [])

    async def _pose(self, stamp: float, seen: Sequence[object]) -> Pose2 | None:
        return await self._poses.at(stamp) if seen and self.odometry.connected else None

    def _look(self, kind: str, source: str, stamp: float, sightings: Sequence[Sighting]) -> None:
        before, rule = self._presence.get(kind, PresenceState()), self.settings.rule(kind)
        self._presence[kind], changes = look(before, rule, source, stamp, sightings)
        self.persistent[_PRESENCE] = self._presence
        for change in changes:
            self.events.publish(event(kind, stamp, change))


def event(kind: str, stamp: float, change: Change) -> PerceptEvent:
    """``change`` of a subject of ``kind``, known by a look at ``stamp``."""
    subject, sighting = change.subject, change.subject.sighting
    return PerceptEvent(
        stamp=stamp,
        name=f"{kind}.{change.verb}",
        kind=kind,
        subject=sighting.subject,
        source=subject.source,
        since=subject.first,
        confidence=sighting.confidence,
        p_OP=sighting.p_O,
        heading=sighting.heading,
    )


def of_codes(message: QRCodes, X_OB: Pose2 | None) -> list[Sighting]:
    """Each code by its text; codes without depth have no place."""
    return [_placed(code.text, 1.0, None if code.p_BQ is None else np.array(code.p_BQ), X_OB) for code in message.codes]


def of_faces(message: Faces, X_OB: Pose2 | None) -> list[Sighting]:
    """Each face by its track's number."""
    return [_placed(str(face.track), face.score, np.array(face.p_BF), X_OB) for face in message.faces]


def of_sources(message: SoundSources, X_OB: Pose2 | None) -> list[Sighting]:
    """Each source that sounds now, by its track's number; its confidence is the probability that it is a voice."""
    found = []
    for source in message.sources:
        if not source.active:
            continue
        direction = np.array(source.direction)
        known = source.range_sigma_m <= _KNOWN * source.range_m
        p_BS = np.array(message.p_BA) + source.range_m * direction if known else None
        heading = None if X_OB is None else wrap_angle(X_OB.theta + math.atan2(direction[1], direction[0]))
        placed = _placed(str(source.track), source.speech, p_BS, X_OB)
        found.append(Sighting(placed.subject, placed.confidence, placed.p_O, heading))
    return found


def _placed(subject: str, confidence: float, p_B: FloatArray | None, X_OB: Pose2 | None) -> Sighting:
    if p_B is None or X_OB is None:
        return Sighting(subject, confidence)
    x, y, z = X_OB.to_pose3().transform(p_B).tolist()
    return Sighting(subject, confidence, (x, y, z), math.atan2(y - X_OB.y, x - X_OB.x))
