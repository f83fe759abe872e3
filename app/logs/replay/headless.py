"""Replays a log without a console: in virtual time, as fast as the machine allows, with the same result each time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from app.attention.intention import Intention
from app.logs.library import RecordingLibrary
from app.logs.log import Log
from app.logs.replay.message_hash import MessageHash
from app.logs.replay.options import ReplayOptions
from app.logs.replay.replay import Replay
from app.logs.replay.replay_config import OWN_RECORDS
from app.logs.replay.report import InputReport, IntentionLine, ReplayedChannel, ReplayedModule, ReplaySummary
from app.messages import LoadReport, LogLine, RecorderStatus
from app.modules.recording.recorder import Recorder
from app.program.system import System
from app.runtime.clock import Clock, VirtualClock, run_virtual

#: A thread that owes a result for longer than this is given up: then only, a replay would depend on the machine.
PATIENCE_S = 600.0
#: Virtual time (s) after the end of the log, in which pending work completes.
TAIL_S = 0.001
#: A replay at a given speed keeps step with real time to this (s of the log).
PACE_S = 0.05
#: A replay that is recorded waits while more than this is queued for the disk, looking so often (real s).
QUEUED_BYTES = 16_000_000
DISK_S = 0.01

#: Records about this computer, or in an order that depends on its threads.
_OF_THE_MACHINE = (LoadReport, LogLine, RecorderStatus)


@dataclass(frozen=True, slots=True)
class ReplayWatch:
    """Callbacks of a replay; all are called on the loop and must not block.

    ``progress(position)``: position so far (robot's clock, s). ``message(channel, message)``: every message that the
    report counts. ``built(system)``: once, when the program is built and before it runs. ``beside(system)`` runs beside
    it, from just before the first message of the log to the end.
    """

    progress: Callable[[float], None] = lambda _: None
    message: Callable[[str, Any], None] = lambda _, __: None
    built: Callable[[System], None] = lambda _: None
    beside: Callable[[System], Coroutine[Any, Any, None]] | None = None


def run_headless(
    log: Log,
    options: ReplayOptions | None = None,
    *,
    speed: float | None = None,
    recordings: RecordingLibrary | None = None,
    watch: ReplayWatch | None = None,
    digests: bool = True,
) -> ReplaySummary:
    """Replay ``log`` and say what came of it; not to be called on an event loop.

    ``speed``: seconds of the log in a real second; None: as fast as possible. Without ``digests`` messages are only
    counted. Raises ConfigError, LogError, and LinkFailed where the log is damaged.
    """
    options = options or ReplayOptions()
    clock = VirtualClock(origin=log.info.begin if options.begin is None else options.begin)
    replay = Replay(log, clock, options, recordings=recordings, reproducible=True)
    watch = watch or ReplayWatch()
    watch.built(replay.system)
    journal = _Journal(replay.system, watch, digests)
    return run_virtual(_run(replay, journal, speed), patience_s=PATIENCE_S)


async def _run(replay: Replay, journal: _Journal, speed: float | None) -> ReplaySummary:
    system, body = replay.system, replay.body
    body.on_piece = journal.watch.progress
    with journal:
        async with replay:
            spent = {name: slot.context.meter.cpu_ns for name, slot in system.graph.modules.items()}
            wall, cpu = time.monotonic(), time.process_time()
            pacing = asyncio.create_task(_pace(system, speed)) if speed is not None else None
            waiting = asyncio.create_task(wait_for_disk(replay.recorder, system.clock)) if replay.recorder else None
            beside = asyncio.create_task(journal.watch.beside(system)) if journal.watch.beside else None
            finished = asyncio.create_task(body.finished.wait())
            failed = asyncio.create_task(system.wait_failed())
            try:
                await asyncio.wait({finished, failed}, return_when=asyncio.FIRST_COMPLETED)
                if failed.done():
                    raise failed.result()
                await system.clock.sleep(TAIL_S)
                await replay.end_recording()
                while replay.recorder is not None and replay.recorder.writing:
                    await _real_sleep(DISK_S)
            finally:
                for task in (finished, failed, pacing, waiting, beside):
                    if task is not None:
                        task.cancel()
            journal.watch.progress(body.end)
            return ReplaySummary(
                file=replay.log.info.path,
                format=replay.log.info.format,
                begin=body.begin,
                end=body.end,
                delivered=body.delivered,
                channels=journal.channels(),
                modules={name: _module(system, name, spent[name]) for name in system.graph.modules},
                intentions=tuple(journal.intentions),
                notes=tuple(replay.notes()),
                wall_s=time.monotonic() - wall,
                cpu_s=time.process_time() - cpu,
                recorded=replay.recorded,
            )


async def _pace(system: System, speed: float) -> None:
    """Hold time up until real time has come as far."""
    began, origin = time.monotonic(), system.clock.now()
    while True:
        await system.clock.sleep(PACE_S)
        early_s = (system.clock.now() - origin) / speed - (time.monotonic() - began)
        if early_s > 0:
            await _real_sleep(early_s)


async def wait_for_disk(recorder: Recorder, clock: Clock) -> None:
    """Hold virtual time up while much waits for the disk, for ever: it may pass faster than can be written."""
    while True:
        await clock.sleep(PACE_S)
        while recorder.queued_bytes > QUEUED_BYTES:
            await _real_sleep(DISK_S)


async def _real_sleep(seconds: float) -> None:
    """Sleep in a thread: virtual time does not pass meanwhile."""
    await asyncio.get_running_loop().run_in_executor(None, time.sleep, seconds)


def _module(system: System, name: str, before_ns: int) -> ReplayedModule:
    slot = system.graph.modules[name]
    inputs = {}
    for port_name, port in slot.context.inputs.items():
        if port.connected and port.channel is not None:
            count = port.subscription.statistics()
            inputs[port_name] = InputReport(
                port.channel.name,
                float(count.divisor),
                received=count.received,
                passed=count.passed,
                taken=count.taken,
                dropped=count.dropped,
            )
    return ReplayedModule(
        cpu_s=(slot.context.meter.cpu_ns - before_ns) / 1e9,
        inputs=inputs,
        outputs={port: system.graph.channels[channel].published for port, channel in sorted(slot.spec.outputs.items())},
        restarts=system.supervisor.states[name].restarts,
    )


class _Journal:
    """Notes what every channel of the program says, without being a consumer of any."""

    def __init__(self, system: System, watch: ReplayWatch, digests: bool) -> None:
        self.watch = watch
        self.intentions: list[IntentionLine] = []
        self._system = system
        self._with_digests = digests
        graph = system.graph
        # Channels of the program's own messages; those fed from the log do not count.
        self._digests = {
            name: MessageHash()
            for name, channel in graph.channels.items()
            if channel.message_type not in _OF_THE_MACHINE
            and (name in graph.producers or channel.message_type in OWN_RECORDS)
        }
        self._stack = ExitStack()

    def __enter__(self) -> _Journal:
        for name in self._digests:
            self._stack.callback(self._system.graph.channels[name].observe(self._noting(name)))
        self._stack.callback(self._system.translator.observe(self._intention))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def channels(self) -> dict[str, ReplayedChannel]:
        """The report of each channel so far."""
        return {
            name: ReplayedChannel(digest.count, digest.hex() if self._with_digests else "")
            for name, digest in self._digests.items()
        }

    def _noting(self, name: str) -> Callable[[Any], None]:
        digest = self._digests[name]

        def note(message: Any) -> None:
            if self._with_digests:
                digest.add(message)
            else:
                digest.count += 1
            self.watch.message(name, message)

        return note

    def _intention(self, intention: Intention) -> None:
        selection = intention.selection
        divisors = self._system.graph.filters.divisors()
        line = IntentionLine(
            intention.stamp,
            selection.strategies,
            fulfilled=selection.fulfilled,
            relaxed=selection.relaxed,
            omega=selection.omega,
            divisors={name: divisors[name] for name in intention.divisors},
        )
        # An intention is reported again once its reasons are complete.
        if not self.intentions or self.intentions[-1] != line:
            self.intentions.append(line)
