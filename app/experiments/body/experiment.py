"""The experiment: a play of desires on a whole program in the simulated world, and what its body did."""

from __future__ import annotations

import asyncio
import statistics
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.experiments.body.measurement import BodyObserver, GroupFigures, Observation, group_figures
from app.experiments.body.play import Play, load_play, perform
from app.experiments.simulated import SimulatedProgram
from app.experiments.world_run import PATIENCE_S
from app.link import RobotDescription
from app.runtime.clock import run_virtual

#: Period (s) of the report of progress.
_PROGRESS_S = 0.5


@dataclass(frozen=True, slots=True)
class Result:
    """``play`` as the ``body`` played it: what was ``seen``, and the ``figures`` of its groups, the base's first.

    ``world_rate``: median of simulated over real time; 1 in virtual time.
    """

    play: Play
    body: RobotDescription
    seen: Observation
    figures: list[GroupFigures]
    world_rate: float


def run(program: SimulatedProgram, play: Path, progress: Callable[[float], None], *, virtual: bool) -> Result:
    """Play it; ``progress(part)`` is called meanwhile. Raises ConfigError, LinkFailed.

    In ``virtual`` time the guard runs in step with the program; else in the process of the body, as in service.
    """
    if virtual:
        return run_virtual(_run(program, play, progress, virtual=True), patience_s=PATIENCE_S)
    return asyncio.run(_run(program, play, progress, virtual=False))


def document(result: Result) -> dict[str, Any]:
    """The figures as JSON values."""
    return {
        "seconds": result.play.seconds,
        "world_rate": round(result.world_rate, 3),
        "groups": [
            {
                "group": each.group,
                "behaviors_s": {name: round(s, 3) for name, s in each.behaviors.items()},
                "guard_s": {name: round(s, 3) for name, s in each.modes.items()},
                "oldest_command_s": None if each.oldest_s is None else round(each.oldest_s, 4),
                "speed_of_limit": round(each.speed, 4),
                "beyond_limit": round(each.beyond, 5),
                "rest_after_stop_s": None if each.rest_s is None else round(each.rest_s, 3),
            }
            for each in result.figures
        ],
    }


async def _run(program: SimulatedProgram, path: Path, progress: Callable[[float], None], *, virtual: bool) -> Result:
    async with AsyncExitStack() as stack:
        system = (program.virtual_system(recorded=False) if virtual else program.system())[0]
        play = load_play(path, set(system.classes))
        await stack.enter_async_context(system)
        observer = BodyObserver(system)
        performing = asyncio.ensure_future(perform(system, play))
        begin = system.clock.now()
        try:
            while not performing.done():
                await system.clock.sleep(_PROGRESS_S)
                progress(min((system.clock.now() - begin) / play.seconds, 1.0))
            seen = observer.end(await performing)
        finally:
            performing.cancel()
        body = system.link.description
    rates = [status.world_rate for _, status in seen.statuses]
    figures = group_figures(seen, body.groups, body.limits)
    return Result(play, body, seen, figures=figures, world_rate=statistics.median(rates) if rates else 0.0)
