"""The tour-guide trial of the thesis (4.4.2, figure 4.8), once, with attention: driven by its script, and told."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from app.attention.desires import Source
from app.experiments.observation import Observer, Outcome
from app.experiments.script import Waypoint, drive_script, load_script
from app.experiments.simulated import SimulatedProgram

_OPERATOR = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class Told:
    """An event of the trial: seconds since its begin, what it is about, in words."""

    at: float
    subject: str
    text: str


#: What of the timeline tells the trial's story.
_KINDS = ("desire", "intention", "guard", "module", "overload")


def run(
    program: SimulatedProgram, record: str | None, leg: Callable[[int, int, str], None]
) -> tuple[Outcome, list[Told]]:
    """Drive the script to its end; ``leg(number, of, label)`` is told each of its legs as it begins.

    ``record``: name of a recording of it, at the fullest rate there is a strategy for. Raises LinkFailed, ConfigError,
    ScriptBlocked.
    """
    return asyncio.run(_run(program, record, leg))


async def _run(
    program: SimulatedProgram, record: str | None, leg: Callable[[int, int, str], None]
) -> tuple[Outcome, list[Told]]:
    script = load_script(program.scenario)

    def progress(number: int, waypoint: Waypoint) -> None:
        leg(number, len(script), waypoint.label)

    system, link = program.system()
    async with system:
        assert link.process_id is not None
        system.workspace.add("Telepresence", intensity=4, utility=1, source=_OPERATOR)
        if record is not None:
            system.workspace.add("Record", intensity=8, utility=8, params={"name": record}, source=_OPERATOR)
        observer = Observer(system, link.process_id)
        observer.begin()
        begin = system.clock.now()
        await drive_script(system, script, progress)
        outcome = observer.outcome(attention=True)
        events = [
            Told(event.stamp - begin, event.subject, event.text)
            for event in system.timeline.query(since=begin, kinds=_KINDS)
        ]
        return outcome, events
