"""The whole program put together from its configuration: link, modules, attention.

The console and the commands see the program only through this file. Everything is built, and every mistake in the
configuration found, before anything starts.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from types import TracebackType

from app.attention.desires import DesireClasses
from app.attention.strategies import load_strategies
from app.attention.timeline import Timeline
from app.attention.translator import Hysteresis, IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.config import Configuration, load_configuration
from app.link import RobotLink
from app.modules.desire_classes import desire_classes
from app.recording.control import RecorderControl
from app.recording.library import RecordingLibrary, default_folder
from app.recording.manifest import Manifest
from app.robots.config import load_robot_config
from app.robots.factory import create_link
from app.runtime.clock import Clock, RealClock
from app.runtime.freshness import FreshnessWatch
from app.runtime.graph import Graph, Pin
from app.runtime.load import LoadMeter
from app.runtime.supervisor import Supervisor
from app.runtime.watchdog import LoopWatchdog
from app.self_report import SelfReport
from app.snapshot import snapshot
from app.timeline_feed import TimelineFeed

LOAD_WINDOW_S = 1.0


class System:
    """A robot program: ``async with System.from_file(path) as system: ...``."""

    def __init__(
        self,
        configuration: Configuration,
        *,
        link: RobotLink | None = None,
        clock: Clock | None = None,
        pins: Mapping[str, Pin] | None = None,
        recordings: RecordingLibrary | None = None,
    ) -> None:
        """Build everything; ``link`` and ``clock`` replace the body that the configuration names and the real clock.

        ``pins`` fixes filters (``Module.port``), whatever strategies say of them. ``recordings`` is where recordings
        are kept, by default the user's folder. Raises ConfigError.
        """
        program = configuration.program
        self.config = configuration
        real = RealClock()
        self.clock: Clock = clock or real
        self.link = link or create_link(load_robot_config(configuration.path(program.robot)), real.offset)
        self.classes = DesireClasses(desire_classes())
        self.workspace = IntentionWorkspace(self.classes, self.clock.now)
        self.timeline = Timeline(program.attention.history, self.clock.now)
        self.recordings = recordings or RecordingLibrary(default_folder())
        self.recorder = RecorderControl()
        services: dict[type[object], object] = {
            RobotLink: self.link,
            IntentionWorkspace: self.workspace,
            RecordingLibrary: self.recordings,
            RecorderControl: self.recorder,
        }
        self.graph = Graph(
            clock=self.clock,
            channels=configuration.channels,
            modules=program.modules,
            services=services,
            error=configuration.wiring_error,
        )
        services[Manifest] = snapshot(configuration, self.graph, self.link.description.name)
        self.table = load_strategies(
            [configuration.path(file) for file in program.strategies],
            classes=self.classes,
            ports=self.graph.ports(),
            calibration=configuration.calibration,
        )
        self.graph.attend(self.table.filters)
        for name, pin in (pins or {}).items():
            self.graph.filters.pin(name, pin)
        self.supervisor = Supervisor(self.graph.modules, self.clock)
        meters = {name: slot.context.meter for name, slot in self.graph.modules.items()}
        self.freshness = FreshnessWatch(self.graph, self.supervisor.states)
        self.load = LoadMeter(meters, self.clock.now)
        self.watchdog = LoopWatchdog(meters)
        self.translator = self._make_translator()
        self._stack = AsyncExitStack()
        self._tasks: list[asyncio.Task[None]] = []
        self._report = SelfReport(self.graph.channels, self.clock.now, self.graph.filters.divisors)
        self._feed = TimelineFeed(
            self.timeline, {n: spec.cpu_budget for n, spec in program.modules.items() if spec.cpu_budget is not None}
        )

    @classmethod
    def from_file(cls, path: Path) -> System:
        """The program that the configuration file at ``path`` describes. Raises ConfigError."""
        return cls(load_configuration(path))

    async def __aenter__(self) -> System:
        """Bring the body up, then attention, then the modules. Raises LinkFailed, having released everything."""
        async with AsyncExitStack() as stack:
            stack.push_async_callback(self.link.stop)
            await self.link.start()
            self.supervisor.observe(self._feed.module)
            self.supervisor.observe(self._report.module)
            self._report.open(self.workspace, self.translator, self.timeline)
            stack.callback(self._report.close)
            stack.callback(self.link.attach("status", self._feed.guard))
            await stack.enter_async_context(self.watchdog)
            await stack.enter_async_context(self.supervisor)
            for name, coroutine in {
                "translator": self.translator.run(),
                "sampling": self._sample(),
                "exploitation": self._follow_exploitation(),
            }.items():
                task = asyncio.create_task(coroutine, name=name)
                self._tasks.append(task)
                stack.push_async_callback(_cancelled, task)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the modules, then the wheels, then the body."""
        await self._stack.aclose()

    async def wait_failed(self) -> Exception:
        """Wait until the program cannot go on, and return why.

        LinkFailed, in words for people, when the body is lost; any other error is a mistake of ours in what runs
        beside the modules (those are restarted), and better met with a stop than with an attention that stands still.
        """
        body = asyncio.create_task(self.link.wait_failed(), name="body's failure")
        try:
            await asyncio.wait({body, *self._tasks}, return_when=asyncio.FIRST_COMPLETED)
            if body.done():
                return body.result()
            ended = next(task for task in self._tasks if task.done())
            error = ended.exception()
            return error if isinstance(error, Exception) else RuntimeError(f"{ended.get_name()} ended by itself")
        finally:
            body.cancel()

    def _make_translator(self) -> IntentionTranslator:
        settings = self.config.program.attention
        try:
            return IntentionTranslator(
                self.workspace,
                self.table,
                self.graph.filters,
                self.graph,
                self.timeline,
                self.clock,
                safe=settings.safe_strategies,
                time_limit_s=settings.solve_time_limit_s,
                hysteresis=Hysteresis(settings.hysteresis_gain, settings.hysteresis_dwell_s),
            )
        except ValueError as failure:
            raise self.config.program_document.error(str(failure), ("attention", "safe_strategies")) from None

    async def _sample(self) -> None:
        while True:
            await self.clock.sleep(LOAD_WINDOW_S)
            load = self.load.sample()
            self._feed.load(load)
            self._report.load(load)
            self._feed.freshness(self.freshness.sample(self.clock.now()))

    async def _follow_exploitation(self) -> None:
        channel = self.graph.channels.get("exploitation")
        if channel is None:  # a program that drives nothing
            await asyncio.Event().wait()
            return
        async for message in channel.subscribe("timeline"):
            self._feed.exploitation(message)


async def _cancelled(task: asyncio.Task[None]) -> None:
    """Cancel ``task`` and wait for its end; a failure of its own is told by :meth:`System.wait_failed`."""
    task.cancel()
    await asyncio.wait({task})
