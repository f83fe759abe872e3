"""A program of one module, the Recorder, on a real clock and real files."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.logs.library import RecordingLibrary
from app.logs.log import Logged
from app.logs.manifest import Manifest
from app.logs.mcap.reader import McapLog
from app.logs.recorder_service import RecorderService
from app.messages import RecorderStatus
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.clock import RealClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.supervisor import Supervisor
from tests.logs.mcap.disks import BEGIN, MANIFEST, odometry
from tests.patience import PATIENCE_S

_ROWS: dict[str, dict[str, Any]] = {
    "kinect": {"type": "Image", "rate_hz": 15},
    "odometry": {"type": "Odometry", "rate_hz": 100},
    "landmarks": {"type": "Landmarks", "latched": True},
    "module_states": {"type": "ModuleRecord", "latched": True},
    "events": {"type": "TimelineEvent"},
    "load": {"type": "LoadReport", "log": "never"},
    "recorder": {"type": "RecorderStatus", "log": "never", "external": False},
}
TABLE = ChannelTable({name: ChannelSpec.model_validate({"external": True, **row}) for name, row in _ROWS.items()})


class Robot:
    """A program of one module, the Recorder, whose strategies would filter the pictures."""

    def __init__(self, folder: Path, **settings: Any) -> None:
        self.library = RecordingLibrary(folder)
        self.control = RecorderService()
        self.clock = RealClock()
        spec = {
            "class": "app.modules.recording.recorder:Recorder",
            "outputs": {"status": "recorder"},
            "settings": {"least_free_mb": 0, **settings},
        }
        self.graph = Graph(
            clock=self.clock,
            channels=TABLE,
            modules={"Recorder": ModuleSpec.model_validate(spec)},
            services={
                RecordingLibrary: self.library,
                RecorderService: self.control,
                Manifest: MANIFEST,
                ChannelTable: TABLE,
            },
            attended=["Recorder.kinect"],
        )
        self.supervisor = Supervisor(self.graph.modules, self.clock)
        self.statuses = self.graph.channel("recorder").subscribe("test", capacity=1000)

    async def __aenter__(self) -> Robot:
        await self.supervisor.__aenter__()
        await self.until(lambda status: status.state == "idle")
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.supervisor.__aexit__(*error)

    def desire(self, wanted: bool = True, **parameters: Any) -> None:
        """As an intention would have it: parameters, and the pictures' filter open."""
        self.graph.filters.apply({"Recorder.kinect": 1 if wanted else float("inf")})
        self.graph.configure("Recorder", {"name": "", "keep_minutes": 0, **parameters} if wanted else {})

    def feed(self, channel: str, message: Any) -> None:
        self.graph.channel(channel).publish(message)

    async def until(self, condition: Callable[[RecorderStatus], bool]) -> RecorderStatus:
        async with asyncio.timeout(PATIENCE_S):
            while not condition(status := await self.statuses.receive()):
                pass
        return status

    async def taken(self, channel: str, count: int) -> None:
        """Until the Recorder has taken ``count`` messages of ``channel`` in all."""
        port = self.graph.modules["Recorder"].context.inputs[channel]
        async with asyncio.timeout(PATIENCE_S):
            while port.subscription.taken < count:  # noqa: ASYNC110  # the loop's next turn is the event
                await asyncio.sleep(0)

    async def record(self, count: int = 100, **parameters: Any) -> RecorderStatus:
        """Begin, feed ``count`` odometries, end; the last status before the end."""
        before = self.graph.modules["Recorder"].context.inputs["odometry"].subscription.taken
        self.desire(**parameters)
        for i in range(count):
            self.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        await self.taken("odometry", before + count)
        self.desire(False)
        return await self.until(lambda status: status.state == "idle")


async def read(path: Path) -> list[Logged]:
    def messages() -> list[Logged]:
        log = McapLog(path)
        try:
            return list(log.messages())
        finally:
            log.close()

    return await asyncio.to_thread(messages)


def of(messages: list[Logged], kind: type) -> list[Any]:
    return [logged.message for logged in messages if isinstance(logged.message, kind)]


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*.mcap"))
