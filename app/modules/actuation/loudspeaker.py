"""Loudspeaker: the arbiter of the robot's voice.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Loudspeaker    in   one per behavior  Audio, one channel, frames of at most 40 ms        │
    │                out  exploitation      Exploitation of the group voice, 10 Hz and when    │
    │                                       another is heard                                   │
    │                out  played            Audio, as the body plays it, by its own stamps     │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Of the behaviors that speak, the one of highest priority is heard; frames of the others are discarded, and
``exploitation`` lets them know, so that they can wait. A frame goes to the robot link at once, which plays frames in
order and drops those that wait too long. A body that reports what it plays has the stream ``loudspeaker``.
"""

from __future__ import annotations

from functools import partial
from types import MappingProxyType
from typing import Self

from pydantic import Field, model_validator

from app.link import RobotLink
from app.messages import Audio, Exploitation, Twist
from app.modules.actuation.arbitration import Contender
from app.modules.actuation.voice_arbitration import VoiceArbiter
from app.modules.stream_module import StreamModule, robot_link
from app.runtime.errors import InboxOverflow
from app.runtime.module import ModuleContext, Settings

#: The actuator group that it arbitrates.
GROUP = "voice"


class LoudspeakerSettings(Settings):
    """Settings of Loudspeaker."""

    behaviors: tuple[Contender, ...] = (Contender(input="voice", behavior="Operator", priority=1),)
    pause_s: float = Field(0.3, gt=0, le=2, description="so long after its last frame a behavior speaks no more")
    period_s: float = Field(0.1, gt=0, le=1, description="who is heard is reported at least this often")

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        ports = [behavior.input for behavior in self.behaviors]
        if len(set(ports)) < len(ports):
            raise ValueError(f"each behavior needs an input of its own, not {', '.join(ports)}")
        return self


class Loudspeaker(StreamModule):
    """Plays one behavior's sound at a time on the robot, and publishes whose."""

    title = "Loudspeaker"
    relays = MappingProxyType({"played": ("loudspeaker", Audio)})
    optional_streams = frozenset({"loudspeaker"})
    Settings = LoudspeakerSettings
    settings: LoudspeakerSettings

    _link: RobotLink

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.exploitation = self.output("exploitation", Exploitation)
        self._arbiter = VoiceArbiter(self.settings.behaviors, self.settings.pause_s)
        self._heard: str | None = None
        self._mute = False
        for contender in self.settings.behaviors:
            # Half a second of the shortest frames that a page sends.
            port = self.input(contender.input, Audio, capacity=50, lossless=True)
            self.on(port, partial(self._play, contender.input))
        self.every(self.settings.period_s, self._report)

    async def start(self) -> None:
        """Look up the body's loudspeaker; a body without one discards the frames."""
        self._link = robot_link(self)
        self._mute = not self._link.description.loudspeaker
        await super().start()

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Frames that are not played in time are dropped."""
        self.log.info("%s", loss)

    async def _play(self, port: str, audio: Audio) -> None:
        if self._mute:
            self._mute = False
            self.log.warning("%s has no loudspeaker: the voice is not played", self._link.description.name)
        if self._arbiter.admit(port, self.clock.now()):
            self._link.play(audio)
        if self._arbiter.speaker(self.clock.now()) != self._heard:
            await self._report()

    async def _report(self) -> None:
        now = self.clock.now()
        self._heard = self._arbiter.speaker(now)
        self.exploitation.publish(Exploitation(now, self._heard, Twist(now, 0.0, 0.0), group=GROUP))
