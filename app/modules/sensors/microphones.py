"""Microphones: the array around the torso, all sampled together (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Microphones    out  audio  Audio, 8 channels, 48 kHz, 16 bit, frames of 512, in base_link│
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``microphones`` is published unchanged, and only while a subscription is open. Sound
may not be decimated: an input for it is open or closed (thesis 4.2.4).
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Audio
from app.modules.stream_module import StreamModule
from app.runtime.module import ModuleContext


class Microphones(StreamModule):
    """The body's ``microphones`` stream on a channel."""

    title = "Microphones"
    streams = MappingProxyType({"audio": "microphones"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.audio = self.output("audio", Audio)

    async def start(self) -> None:
        """Attach to the body's stream. Raises ModuleFailed for a body without microphones."""
        self.relay("microphones", self.audio, lazy=True)
