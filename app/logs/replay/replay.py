"""A replay: the log's program on a body that plays the log, with the recorded inputs from outside."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType

from app.attention.desires import InvalidDesire, Source
from app.base.errors import ConfigError
from app.logs.library import RecordingLibrary
from app.logs.log import Log
from app.logs.mcap.damage import missing
from app.logs.recorder_service import RECORD
from app.logs.replay.options import ReplayOptions
from app.logs.replay.recorded_desires import CountedIds, RecordedDesires
from app.logs.replay.replay_config import NOT_ASKED, ReplayProgram, idle_modules, prepare
from app.logs.replay.state_at import RecordedState
from app.messages import Desires, RecorderStatus
from app.modules.recording.recorder import Recorder
from app.program.system import System
from app.robots.replayed.link import ReplayedLink
from app.runtime.clock import Clock
from app.runtime.filter_bank import Pin


class Replay:
    """``async with Replay(log, clock) as replay``: its ``system`` runs, its ``body`` delivers the recorded messages.

    ``clock`` is at ``options.begin`` (or the log's begin) when the replay is entered, and drives everything; its owner
    sets the speed, and must not let it run while the replay is being entered unless it is virtual. The caller closes
    the log afterwards. The constructor reads files: call it off the event loop.
    """

    def __init__(
        self,
        log: Log,
        clock: Clock,
        options: ReplayOptions | None = None,
        *,
        recordings: RecordingLibrary | None = None,
        reproducible: bool = False,
    ) -> None:
        """Build everything. ``reproducible`` as for ``System``. Raises ConfigError, LogError."""
        self.log = log
        self.options = options or ReplayOptions()
        self._folder = TemporaryDirectory(prefix="hbba-replay-")
        self._stack = AsyncExitStack()
        self._recording: str | None = None
        #: Name of the replay's own recording, from its begin on.
        self.recorded = ""
        try:
            ids = CountedIds()
            # The inputs of a module are known once the program is built; it is built again without modules that get no
            # message.
            idle: dict[str, str] = {}
            while True:
                folder = Path(self._folder.name) / str(len(idle))
                self.program: ReplayProgram = prepare(log, self.options, folder, idle, watched=not reproducible)
                self.body = ReplayedLink(
                    log,
                    clock,
                    self.program.description,
                    self.program.streams,
                    begin=self.options.begin,
                    end=self.options.end,
                    hold=True,
                )
                self.system = System(
                    self.program.configuration,
                    link=self.body,
                    clock=clock,
                    recordings=recordings,
                    new_id=ids,
                    partial=True,
                    reproducible=reproducible,
                    recorded=self.program.fed,
                )
                if not (more := idle_modules(self.program, self.system.graph)):
                    break
                idle |= more
            self._pin()
        except BaseException:
            self._folder.cleanup()
            raise
        self._desires = RecordedDesires(
            self.system.workspace, ids, self.system.graph.modules.keys(), clock.now, ignored={RECORD}
        )
        #: Channels of the log with records of desires.
        self._desire_channels = [name for name, channel in log.info.channels.items() if channel.message_type is Desires]

    def notes(self) -> list[str]:
        """Differences from the recorded program, in sentences for people."""
        program = self.program
        lines = list(self.log.info.notes)
        lines += [f"{name} does not run: {why}" for name, why in program.left_out.items() if why != NOT_ASKED]
        lines += [f"{port} gets nothing: the log has no {channel}" for port, channel in program.silent.items()]
        lines += [f"the log is damaged: {missing(damage, self.log.info)}" for damage in self.body.damages]
        return lines

    def close(self) -> None:
        """Remove the log's files, of a replay that is never entered; may be called twice."""
        self._folder.cleanup()

    async def __aenter__(self) -> Replay:
        """Start the program, add the desires of the beginning, start the log. Raises LinkFailed, ConfigError."""
        async with AsyncExitStack() as stack:
            stack.push_async_callback(asyncio.to_thread, self.close)
            await stack.enter_async_context(self.system)
            self._connect(stack)
            await self._started()
            await self.system.translator.settled()
            if self.options.desires and self._desire_channels:
                # The body, held, does not read yet.
                for logged in await asyncio.to_thread(RecordedState(self.log).of_types, (Desires,), self.body.begin):
                    self._desires.take(logged.message)
            self._record()
            await self.system.translator.settled()
            for module, parameters in self.options.parameters.items():
                self.system.graph.configure(module, parameters)
            self._stack = stack.pop_all()
        self.body.release()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the program; remove the log's files."""
        await self._stack.aclose()

    @property
    def recorder(self) -> Recorder | None:
        """The module that records the replay, if it is recorded."""
        modules = (slot.module for slot in self.system.graph.modules.values())
        return next((module for module in modules if isinstance(module, Recorder)), None)

    async def end_recording(self) -> None:
        """Withdraw the desire to record the replay; its file is closed some time later (``recorder.writing``)."""
        if self._recording is not None:
            self.system.workspace.remove(self._recording)
            self._recording = None
            await self.system.translator.settled()

    def _pin(self) -> None:
        filters, offset = self.system.graph.filters, self.options.offset
        try:
            for name, divisor in self.options.phi.items():
                filters.pin(name, Pin(divisor, offset))
            for name, pin in self.options.pins.items():
                filters.pin(name, pin)
            filters.delay(offset)
        except (KeyError, ValueError) as failure:
            raise ConfigError(str(failure.args[0]), "--phi") from None

    def _connect(self, stack: AsyncExitStack) -> None:
        """Feed channels without a producer, and desires, from the log."""
        graph = self.system.graph
        for name in self.program.fed:
            channel = graph.channels[name]
            stack.callback(channel.on_wanted(self.body.feed(name, channel.publish).demand))
        if self.options.desires:
            for name in self._desire_channels:
                self.body.feed(name, self._desires.take).demand(True)
            self.body.on_seek = lambda: self._desires.take(None)

    async def _started(self) -> None:
        """Wait until every module runs, or has failed to."""
        supervisor = self.system.supervisor
        changed = asyncio.Event()
        end = supervisor.observe(lambda _: changed.set())
        try:
            while any(state.status in ("starting", "stopped") for state in supervisor.states.values()):
                changed.clear()
                await changed.wait()
        finally:
            end()

    def _note_recording(self, status: RecorderStatus) -> None:
        self.recorded = status.name or self.recorded

    def _record(self) -> None:
        if self.options.record is None:
            return
        for channel in self.system.graph.channels.values():
            if channel.message_type is RecorderStatus:
                channel.observe(self._note_recording)
        try:
            self._recording = self.system.workspace.add(
                RECORD,
                intensity=8,
                utility=1,
                source=Source("operator", "replay"),
                params={"name": self.options.record},
            ).id
        except InvalidDesire as failure:
            raise ConfigError(str(failure), "--record") from None
