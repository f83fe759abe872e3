"""The tour-guide trial of the thesis (4.4.2, figure 4.8), once, with attention: driven by its script."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from app.attention.desires import Source
from app.base.errors import ConfigError
from app.experiments.observation import Observer, Outcome
from app.experiments.script import Waypoint, drive_script, load_script
from app.experiments.simulated import SimulatedProgram
from app.experiments.world_run import PATIENCE_S
from app.logs.recorder_service import RECORD
from app.logs.replay.headless import wait_for_disk
from app.modules.recording.recorder import Recorder
from app.program.system import System
from app.runtime.clock import run_virtual

_OPERATOR = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class TrialEvent:
    """An event of the trial: seconds since its begin, its kind, its text."""

    at: float
    subject: str
    text: str


#: Period (real s) of the check whether the file is closed.
_LOOK_S = 0.05
#: Kinds of timeline events that are reported.
_KINDS = ("desire", "intention", "guard", "module", "overload")


def run(
    program: SimulatedProgram,
    record: str | None,
    leg: Callable[[int, int, str], None],
    *,
    virtual: bool = False,
) -> tuple[Outcome, list[TrialEvent]]:
    """Drive the script to its end; ``leg(number, of, label)`` is called at the begin of each leg.

    ``record``: name of a recording of it, at the fullest rate there is a strategy for. In ``virtual`` time every sensor
    keeps its rate and nothing is late, however slow the computer; CPU figures are meaningless then. Raises LinkFailed,
    ConfigError, ScriptBlocked.
    """
    if not virtual:
        return asyncio.run(_run(program, record, leg))
    return run_virtual(_run(program, record, leg, virtual=True), patience_s=PATIENCE_S)


async def _run(
    program: SimulatedProgram, record: str | None, leg: Callable[[int, int, str], None], *, virtual: bool = False
) -> tuple[Outcome, list[TrialEvent]]:
    script = load_script(program.scenario)

    def progress(number: int, waypoint: Waypoint) -> None:
        leg(number, len(script), waypoint.label)

    body: int | None = None
    async with AsyncExitStack() as stack:
        if virtual:
            system, _ = program.virtual_system(recorded=record is not None)
            await stack.enter_async_context(system)
        else:
            system, link = program.system()
            await stack.enter_async_context(system)
            body = link.process_id
            assert body is not None
        system.workspace.add("Telepresence", intensity=4, utility=1, source=_OPERATOR)
        if record is not None:
            system.workspace.add("Record", intensity=8, utility=8, params={"name": record}, source=_OPERATOR)
            if virtual:
                await stack.enter_async_context(_unhurried(system))
        observer = Observer(system, body)
        observer.begin()
        begin = system.clock.now()
        await drive_script(system, script, progress)
        outcome = observer.outcome(attention=True)
        events = [
            TrialEvent(event.stamp - begin, event.subject, event.text)
            for event in system.timeline.query(since=begin, kinds=_KINDS)
        ]
        return outcome, events


@asynccontextmanager
async def _unhurried(system: System) -> AsyncIterator[None]:
    """Hold virtual time up for what is recorded, and have the file closed before the end."""
    modules = (slot.module for slot in system.graph.modules.values())
    recorder = next((module for module in modules if isinstance(module, Recorder)), None)
    if recorder is None:
        raise ConfigError("this program has no Recorder: nothing can be recorded", system.config.program_document.file)
    waiting = asyncio.create_task(wait_for_disk(recorder, system.clock))
    try:
        yield
        for desire in system.workspace.desires():
            if desire.cls == RECORD:
                system.workspace.remove(desire.id)
        await system.translator.settled()
        while recorder.writing:
            await asyncio.to_thread(time.sleep, _LOOK_S)
    finally:
        waiting.cancel()
