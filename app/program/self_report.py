"""The program's own records as messages on channels: desires, intentions, φ, load, modules, events, log lines.

So the Recorder depends on neither attention nor supervision: it records channels. Each record is published at a change
of its subject, on the channel of its name if the table of channels has it.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any, Protocol

from app.attention.intention import Intention
from app.attention.reports import desires_report, intention_report
from app.attention.timeline import Timeline
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.messages import (
    DesireProgress,
    Divisors,
    LoadReport,
    LogLine,
    ModuleRecord,
    TimelineEvent,
)
from app.runtime.channel import Channel
from app.runtime.supervisor import ModuleState

#: Loggers of the Recorder itself and of the layers below it: recording their lines would cause more lines.
_NOT_RECORDED = ("hbba.Recorder", "asyncio")


class DesireWatch(Protocol):
    """What has become of the desires."""

    def exploited(self) -> tuple[str, ...]:
        """Ids of the desires that are exploited now."""
        ...

    def progress(self) -> tuple[DesireProgress, ...]:
        """What has become of each desire so far."""
        ...


class SelfReport:
    """Publishes the records; :meth:`open` registers its observers, :meth:`close` removes them."""

    def __init__(
        self,
        channels: Mapping[str, Channel[Any]],
        now: Callable[[], float],
        divisors: Callable[[], Mapping[str, float]],
    ) -> None:
        """``channels`` by name: those among ``workspace``, ``intention``, ``divisors``, ``load``, ``module_states``,
        ``events`` and ``log`` that are there are published on. ``divisors`` gives φ of every filter."""
        self._channels = channels
        self._now = now
        self._stack = ExitStack()
        self._divisors = divisors
        self._published: Mapping[str, float] = {}
        self._workspace: IntentionWorkspace | None = None
        self._translator: IntentionTranslator | None = None
        self._exploitation: DesireWatch | None = None
        self._published_progress: tuple[DesireProgress, ...] = ()

    def open(
        self,
        workspace: IntentionWorkspace,
        translator: IntentionTranslator,
        timeline: Timeline,
        exploitation: DesireWatch,
    ) -> None:
        """Start to publish attention's records and log lines. ``exploitation`` gives what has become of the desires; it
        is published again after an event of exploitation or intention that changes it."""
        self._workspace, self._translator, self._exploitation = workspace, translator, exploitation
        self._stack.callback(workspace.observe(lambda _: self._desires()))
        self._stack.callback(translator.observe(self._intention))
        self._stack.callback(timeline.observe(self._event))
        if "log" in self._channels:
            handler = _LogHandler(asyncio.get_running_loop(), self._log_line)
            logging.getLogger().addHandler(handler)
            self._stack.callback(logging.getLogger().removeHandler, handler)

    def close(self) -> None:
        """Stop publishing."""
        self._stack.close()

    def again(self) -> None:
        """Publish desires and the intention in force again: channels have been cleared."""
        if self._workspace is not None:
            self._desires()
        if self._translator is not None and self._translator.current is not None:
            self._intention(self._translator.current)

    def load(self, load: LoadReport) -> None:
        """A load window closed."""
        self._publish("load", load)

    def module(self, state: ModuleState) -> None:
        """A module's state changed."""
        record = ModuleRecord(self._now(), state.name, state.status, state.restarts, state.problem)
        self._publish("module_states", record)

    def _publish(self, channel: str, record: Any) -> None:
        if channel in self._channels:
            self._channels[channel].publish(record)

    def _desires(self) -> None:
        assert self._workspace is not None
        assert self._exploitation is not None
        exploited, progress = self._exploitation.exploited(), self._exploitation.progress()
        self._published_progress = progress
        self._publish("workspace", desires_report(self._workspace, self._now(), exploited, progress))

    def _event(self, event: TimelineEvent) -> None:
        self._publish("events", event)
        if event.kind not in ("exploitation", "intention") or self._exploitation is None:
            return
        if self._exploitation.progress() != self._published_progress:
            self._desires()

    def _intention(self, intention: Intention) -> None:
        assert self._translator is not None
        self._publish("intention", intention_report(intention, self._translator.table.resources))
        everything = self._divisors()
        divisors = {name: everything[name] for name in intention.divisors}
        if divisors != self._published:
            self._published = divisors
            self._publish("divisors", Divisors(self._now(), tuple(divisors), tuple(divisors.values())))

    def _log_line(self, level: int, source: str, text: str) -> None:
        self._publish("log", LogLine(self._now(), level, source, text))


class _LogHandler(logging.Handler):
    """Passes log lines of any thread to the event loop."""

    def __init__(self, loop: asyncio.AbstractEventLoop, take: Callable[[int, str, str], None]) -> None:
        super().__init__(logging.INFO)
        self._loop = loop
        self._take = take

    def emit(self, record: logging.LogRecord) -> None:
        """Pass it on; a line that comes after the loop's end has no place in a recording."""
        if record.name.startswith(_NOT_RECORDED) or self._loop.is_closed():
            return
        self._loop.call_soon_threadsafe(self._take, record.levelno, record.name, record.getMessage())
