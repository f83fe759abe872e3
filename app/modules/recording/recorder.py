"""Recorder: what the robot lives, on disk (thesis 4.4: every experiment was recorded).

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ Recorder    in   <channel>  every channel whose `log` is not `never`, or those named    │
│             out  status     RecorderStatus, 1 Hz and at every change                    │
└─────────────────────────────────────────────────────────────────────────────────────────┘
"""

from __future__ import annotations

from collections.abc import Mapping

from app.messages import Message, RecorderStatus
from app.runtime.channel_table import ChannelSpec
from app.runtime.module import Module, ModuleContext


class Recorder(Module):
    """Writes every message it is given into a log."""

    title = "Recorder"

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.status = self.output("status", RecorderStatus)
        for port in context.inputs.values():
            self.on(port, self._take)

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """Everything that may be recorded, on ports named as the channels."""
        return {name: name for name, spec in channels.items() if spec.log != "never"}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any channel, losing nothing."""
        self.on(self.input(name, message_type, capacity=256, lossless=True), self._take)

    async def _take(self, message: Message) -> None:
        """Not recorded yet."""
