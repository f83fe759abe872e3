"""One trial in two conditions on a computer too small for everything: all filters open, then with attention.

The thesis's trials (4.4.2) compared both on a robot with too little CPU: without filtering, loops missed their rate and
the robot stuttered. Here the program is confined to one core (or a share of it), the world to the others; the
scenario's script drives the robot, people walk, talk and clap.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.attention.desires import Source
from app.experiments.observation import Observer, Outcome
from app.experiments.overload.confinement import confined
from app.experiments.script import ScriptBlocked, Waypoint, drive_script, load_script
from app.experiments.simulated import SimulatedProgram, simulated_program
from app.runtime.filter_bank import Pin

#: Time (s) before the measurement, for all modules to start.
SETTLE_S = 3.0
PERIOD_S = 0.25
#: Desires of an operator who watches.
WATCHING = ("Telepresence",)
#: Left out: a Recorder's inputs are no perception's.
NOT_PERCEPTION = ("Recorder",)

OnProgress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True)
class OverloadPlan:
    """A plan: the program in its world, the script, the duration, the share of a core."""

    program: SimulatedProgram
    script: tuple[Waypoint, ...]
    seconds: float
    budget: float


def plan(config: Path | None, scenario: Path | None, seconds: float, budget: float) -> OverloadPlan:
    """Read everything. Raises ConfigError."""
    program = simulated_program(config, scenario)
    return OverloadPlan(program, load_script(program.scenario), seconds, budget)


def run(what: OverloadPlan, on_progress: OnProgress) -> tuple[Outcome, Outcome]:
    """Without attention, then with it. ``on_progress(condition, share)`` reports progress in [0, 1]. Raises LinkFailed,
    ConfigError."""
    without = asyncio.run(_condition(what, False, lambda part: on_progress("everything at φ = 1", part / 2)))
    kept = asyncio.run(_condition(what, True, lambda part: on_progress("with attention", 0.5 + part / 2)))
    return without, kept


async def _condition(what: OverloadPlan, attention: bool, on_progress: Callable[[float], None]) -> Outcome:
    system, link = what.program.system()
    clock = system.clock
    if not attention:
        for name in system.table.filters:
            if name.partition(".")[0] not in NOT_PERCEPTION:
                system.graph.filters.pin(name, Pin(1))
    async with system:
        assert link.process_id is not None
        for cls in WATCHING:
            if cls in system.classes:
                system.workspace.add(cls, intensity=4, utility=1, source=Source("operator", "the experiment"))
        with confined(link.process_id, what.budget):
            await clock.sleep(SETTLE_S)
            observer = Observer(system, link.process_id)
            observer.begin()
            driving = asyncio.create_task(drive_script(system, what.script), name="script")
            began = clock.now()
            try:
                while (passed := clock.now() - began) < what.seconds:
                    on_progress(passed / what.seconds)
                    await clock.sleep(PERIOD_S)
            finally:
                how = _how(driving)
                driving.cancel()
                await asyncio.wait({driving})
            return observer.outcome(attention=attention, script=how)


def _how(driving: asyncio.Task[None]) -> str:
    """Progress of the script as text: a robot without enough CPU may not finish it. Raises its programming errors."""
    if not driving.done():
        return "under way"
    try:
        driving.result()
    except ScriptBlocked as failure:
        return f"given up: {failure}"
    return "driven to its end"
