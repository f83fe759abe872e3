"""Loudspeaker: the operator's voice at the robot.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Loudspeaker    in   voice  Audio, one channel, frames of at most 40 ms, as they come      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: each frame goes to the robot link at once, which plays frames in order and drops those that wait too
long.
"""

from __future__ import annotations

from app.link import RobotLink
from app.messages import Audio
from app.modules.stream_module import robot_link
from app.runtime.errors import InboxOverflow
from app.runtime.module import Module, ModuleContext


class Loudspeaker(Module):
    title = "Loudspeaker"

    _link: RobotLink

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._mute = False
        # Half a second of the shortest frames that a page sends.
        self.voice = self.input("voice", Audio, capacity=50, lossless=True)
        self.on(self.voice, self._play)

    async def start(self) -> None:
        """Look up the body's loudspeaker; a body without one discards the frames."""
        self._link = robot_link(self)
        self._mute = not self._link.description.loudspeaker

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Frames that are not played in time are dropped."""
        self.log.info("%s", loss)

    async def _play(self, audio: Audio) -> None:
        if self._mute:
            self._mute = False
            self.log.warning("%s has no loudspeaker: the voice is not played", self._link.description.name)
        self._link.play(audio)
