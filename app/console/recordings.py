"""The Recorder's state for pages and REST, and requests to record, which are desires."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from app.attention.desires import Desire, Source
from app.console.records.recordings import RecorderReport
from app.logs.recorder_service import RECORD
from app.messages import RecorderState, RecorderStatus
from app.runtime.channel import Channel

if TYPE_CHECKING:
    from app.program.system import System

INTENSITY = 8.0
UTILITY = 1.0
#: Who asks over the console; a motivation's desire to record is not for people here to withdraw.
_ASKED_HERE = ("operator", "rest")
#: While a file is being written, its size is sent this often (s).
_NEWS_AFTER_S = 0.9


class RecorderWatch:
    """What the Recorder does; ``channel`` is where it reports so, None in a program without a Recorder."""

    def __init__(self, system: System) -> None:
        self._system = system
        graph = system.graph
        found = [name for name in graph.producers if graph.channels[name].message_type is RecorderStatus]
        self.channel: Channel[RecorderStatus] | None = graph.channels[found[0]] if found else None
        self._module = graph.producers[found[0]].partition(".")[0] if found else ""
        self._served = any(strategy.cls == RECORD for strategy in system.table.strategies)
        self._reported: tuple[Any, ...] = ()
        self._reported_at = 0.0

    @property
    def available(self) -> bool:
        """Whether a Recorder runs and attention has a strategy for it: a desire to record can come true."""
        return self.channel is not None and self._served and self._system.recorder.available

    @property
    def status(self) -> RecorderStatus:
        """What it said last; before that, that it is idle."""
        latest = None if self.channel is None else self.channel.latest
        return latest or RecorderStatus(
            0.0, "idle", name="", began=0.0, duration_s=0.0, bytes=0, messages=0, dropped=0, queued_bytes=0, reason=""
        )

    def writes(self, name: str) -> bool:
        """Whether the recording ``name`` is being written now."""
        return self.status.name == name and self._state() in ("recording", "ring")

    def in_progress(self) -> str | None:
        """Name of the file that people have recorded now, "" where it has none yet; None if there is none.

        A ring is none, nor what the robot's own motivations record: those give way to what people ask for.
        """
        desire = self._system.workspace.strongest().get(RECORD)
        if desire is None or desire.utility <= 0 or desire.source.kind not in _ASKED_HERE:
            return None
        if desire.params.get("keep_minutes", 0) > 0 or self._state() == "stopped" or self._reason(desire):
            return None
        return self.status.name if self._state() == "recording" else str(desire.params.get("name", ""))

    def report(self) -> RecorderReport | None:
        """What it does now; None in a program without a Recorder."""
        if self.channel is None:
            return None
        status, state = self.status, self._state()
        busy = state in ("recording", "ring")
        current = self._system.translator.current
        parameters = {} if current is None else current.parameters.get(self._module, {})
        desire = self._system.workspace.strongest().get(RECORD)
        return RecorderReport(
            stamp=self._system.clock.now(),
            state=state,
            name=status.name,
            began=status.began or None,
            duration_s=round(status.duration_s, 3),
            bytes=status.bytes,
            messages=status.messages,
            dropped=status.dropped,
            queued_bytes=status.queued_bytes,
            keep_minutes=parameters.get("keep_minutes", 0) if busy else 0,
            desired=desire is not None and desire.utility > 0,
            reason=self._reason(desire),
            available=self.available,
        )

    def problem(self) -> str:
        """Why the recording that was running has ended by itself, in words, until it is stopped or another begins; ""
        where none has."""
        status = self.status
        return f"recording stopped: {status.reason}" if status.state == "stopped" and status.reason else ""

    def news(self) -> bool:
        """Whether a new report is due since this was last True: after a change, or after enough time."""
        now_so = self.report()
        if now_so is None:
            return False
        words = (
            now_so.state,
            now_so.name,
            now_so.dropped,
            now_so.keep_minutes,
            now_so.desired,
            now_so.reason,
            now_so.available,
        )
        now = self._system.clock.now()
        if words == self._reported and now - self._reported_at < _NEWS_AFTER_S:
            return False
        self._reported, self._reported_at = words, now
        return True

    def _state(self) -> RecorderState:
        state = self.status.state
        return "stopped" if self._failure() and state in ("recording", "ring") else state

    def _failure(self) -> str:
        """Why the module cannot record at all, in words; "" while it runs."""
        state = self._system.supervisor.states.get(self._module)
        if state is None or state.status == "running" or (state.status == "starting" and not state.problem):
            return ""
        return f"the Recorder is {state.status}" + (f": {state.problem}" if state.problem else "")

    def _reason(self, desire: Desire | None) -> str:
        if said := self._failure() or self.status.reason:
            return said
        current = self._system.translator.current
        if desire is None or current is None or self.status.state in ("recording", "ring"):
            return ""
        # Of an intention that answers an older desire, nothing follows for this one.
        answered = current.desires.get(RECORD)
        reason = current.reasons.get(RECORD)
        if reason is None or answered is None or answered.id != desire.id:
            return ""
        return reason.text if reason.state in ("unfulfilled", "inhibited") else ""


def record(
    system: System, source: Source, *, name: str, keep_minutes: float, intensity: float, utility: float
) -> Desire:
    """Desire a recording, or a ring of the last ``keep_minutes``. Raises InvalidDesire."""
    params = {"name": name, "keep_minutes": keep_minutes}
    return system.workspace.add(RECORD, intensity=intensity, utility=utility, params=params, source=source)


def withdraw(system: System) -> tuple[list[Desire], list[Desire]]:
    """Withdraw every desire to record that came over the console; returns those, and those that remain."""
    asked = [desire for desire in system.workspace.desires() if desire.cls == RECORD]
    ours = [desire for desire in asked if desire.source.kind in _ASKED_HERE]
    with system.workspace.transaction():
        for desire in ours:
            system.workspace.remove(desire.id)
    return ours, [desire for desire in asked if desire not in ours]
