"""A Recorder without sensors: it writes two messages, as attention asks, and reports what the test wants."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

from mcap.writer import Writer

from app.logs.layout import FACTS
from app.logs.library import RecordingLibrary
from app.logs.log import LogError
from app.logs.recorder_service import RecorderService, RecorderUnavailable
from app.logs.stamps import to_ns
from app.messages import Image, RecorderStatus
from app.program.system import System
from app.runtime.module import Module, ModuleContext

LENGTH_S = 3.0


def write_log(path: Path, begin: float, duration_s: float = LENGTH_S, *, closed: bool = True) -> None:
    """A recording of ``duration_s``, as an MCAP file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=64)
        writer.start(profile="ros2")
        writer.add_metadata(FACTS, {"robot": "a test body"})
        channel = writer.register_channel("/topic", "cdr", 0)
        for stamp in (begin, begin + duration_s):
            writer.add_message(channel, to_ns(stamp), bytes(1000), to_ns(stamp))
        if closed:
            writer.finish()


class ScriptedRecorder(Module):
    """Records while its parameters say so; :meth:`say` has it say anything."""

    title = "Recorder"

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.input("kinect", Image, capacity=4)
        self.status = self.output("status", RecorderStatus)
        self.library = self.service(RecordingLibrary)
        self.control = self.service(RecorderService)
        self.disk_full = False
        self._detach: Callable[[], object] = lambda: None
        self._changing: asyncio.Task[None] | None = None
        self._name = ""
        self._began = 0.0
        self._ring = False

    async def start(self) -> None:
        self._detach = self.control.attach(self._save)
        self.say("idle")

    async def stop(self) -> None:
        self._detach()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._changing = asyncio.create_task(self._change(parameters))

    async def _change(self, parameters: Mapping[str, Any]) -> None:
        if self._name and not self._ring:
            await asyncio.to_thread(write_log, self.library.path(self._name), self._began)
        self._name = ""
        if not parameters:
            self.say("idle")
            return
        self._ring = parameters["keep_minutes"] > 0
        self._name = parameters["name"] or "2026-11-21-10-00-00"
        self._began = self.clock.now()
        if not self._ring:
            await asyncio.to_thread(write_log, self.library.path(self._name), self._began, closed=False)
        self.say("ring" if self._ring else "recording")

    def say(
        self,
        state: Literal["idle", "recording", "ring", "stopped"],
        *,
        reason: str = "",
        messages: int = 0,
        dropped: int = 0,
    ) -> None:
        """Publish a status."""
        busy = state in ("recording", "ring")
        name, began = (self._name, self._began) if busy else ("", 0.0)
        status = RecorderStatus(
            self.clock.now(), state, name, began, 1.5 * busy, 1000 * busy, messages, dropped, 0, reason
        )
        self.status.publish(status)

    async def _save(self, minutes: float | None, name: str | None) -> str:
        if not self._ring or not self._name:
            raise RecorderUnavailable("no ring turns: desire Record with keep_minutes above 0 first")
        if self.disk_full:
            raise LogError("the disk is full: delete recordings")
        saved = name or "saved"
        await asyncio.to_thread(write_log, self.library.path(saved), self._began, 60 * (minutes or 2))
        return saved


async def heard(system: System, state: str) -> None:
    """Wait until the Recorder says that it is in ``state``."""
    channel = system.graph.channel("recorder")
    subscription = channel.subscribe("test", capacity=8)
    try:
        if channel.latest is None or channel.latest.state != state:
            async for status in subscription:
                if status.state == state:
                    return
    finally:
        channel.unsubscribe(subscription)
