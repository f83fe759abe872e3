"""The program's own records as messages on channels: desires, intentions, φ, load, modules, events, log lines.

So the Recorder depends on neither attention nor supervision: it records channels. Each record is published at a change
of its subject, on the channel of its name if the table of channels has it.
"""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

from app.attention.desires import Desire
from app.attention.intention import Intention
from app.attention.timeline import Timeline, TimelineEvent
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.messages import (
    DesireRecord,
    DesiresRecord,
    Divisors,
    EventRecord,
    IntentionRecord,
    LoadRecord,
    LogLine,
    ModuleRecord,
    ReasonRecord,
)
from app.runtime.channel import Channel
from app.runtime.load import CpuLoad
from app.runtime.supervisor import ModuleState

NEVER = float("inf")

#: Loggers of the Recorder itself and of the layers below it: recording their lines would cause more lines.
_NOT_RECORDED = ("hbba.Recorder", "asyncio")


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

    def open(self, workspace: IntentionWorkspace, translator: IntentionTranslator, timeline: Timeline) -> None:
        """Start to publish attention's records and log lines."""
        self._stack.callback(workspace.observe(lambda _: self._desires(workspace)))
        self._stack.callback(translator.observe(self._intention))
        self._stack.callback(timeline.observe(self._event))
        if "log" in self._channels:
            handler = _LogHandler(asyncio.get_running_loop(), self._log_line)
            logging.getLogger().addHandler(handler)
            self._stack.callback(logging.getLogger().removeHandler, handler)

    def close(self) -> None:
        """Stop publishing."""
        self._stack.close()

    def load(self, load: CpuLoad) -> None:
        """A load window closed."""
        modules = tuple(load.modules)
        self._publish(
            "load", LoadRecord(load.stamp, load.window_s, modules, tuple(load.modules.values()), load.process)
        )

    def module(self, state: ModuleState) -> None:
        """A module's state changed."""
        record = ModuleRecord(self._now(), state.name, state.status, state.restarts, state.problem)
        self._publish("module_states", record)

    def _publish(self, channel: str, record: Any) -> None:
        if channel in self._channels:
            self._channels[channel].publish(record)

    def _desires(self, workspace: IntentionWorkspace) -> None:
        records = tuple(desire_record(desire) for desire in workspace.desires())
        self._publish("workspace", DesiresRecord(self._now(), records))

    def _intention(self, intention: Intention) -> None:
        self._publish("intention", intention_record(intention))
        everything = self._divisors()
        divisors = {name: everything[name] for name in intention.divisors}
        if divisors != self._published:
            self._published = divisors
            self._publish("divisors", Divisors(self._now(), tuple(divisors), tuple(divisors.values())))

    def _event(self, event: TimelineEvent) -> None:
        data = json.dumps(dict(event.data), ensure_ascii=False)
        self._publish(
            "events",
            EventRecord(event.stamp, event.kind, subject=event.subject, text=event.text, data=data, id=event.id),
        )

    def _log_line(self, level: int, source: str, text: str) -> None:
        self._publish("log", LogLine(self._now(), level, source, text))


def desire_record(desire: Desire) -> DesireRecord:
    """A desire as it is recorded."""
    return DesireRecord(
        id=desire.id,
        cls=desire.cls,
        intensity=desire.intensity,
        utility=desire.utility,
        security=desire.security,
        params=json.dumps(dict(desire.params), ensure_ascii=False),
        source_kind=desire.source.kind,
        source_name=desire.source.name,
        created=desire.created,
        expires=NEVER if desire.expires is None else desire.expires,
    )


def intention_record(intention: Intention) -> IntentionRecord:
    """An intention as it is recorded."""
    selection = intention.selection
    resources = tuple(intention.capacities)
    parameters = {module: dict(values) for module, values in intention.parameters.items()}
    return IntentionRecord(
        stamp=intention.stamp,
        strategies=selection.strategies,
        fulfilled=selection.fulfilled,
        relaxed=selection.relaxed,
        omega=selection.omega,
        bound=selection.bound,
        proven=selection.proven,
        solve_time_s=selection.solve_time_s,
        resources=resources,
        used=tuple(selection.use.get(name, 0.0) for name in resources),
        capacities=tuple(intention.capacities.values()),
        parameters=json.dumps(parameters, ensure_ascii=False),
        reasons=tuple(
            ReasonRecord(
                cls, reason.state, utility=reason.utility, wanted=reason.wanted, best=reason.best, text=reason.text
            )
            for cls, reason in intention.reasons.items()
        ),
    )


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
