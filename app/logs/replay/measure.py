"""Runs of a calibration: headless replays of one module alone, its CPU time and its percepts counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import is_dataclass
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from app.logs.log import Log
from app.logs.replay.batch_replay import batch_program, serialize_computing
from app.logs.replay.calibration_runs import Measurement, Run
from app.logs.replay.headless import ReplayWatch, run_headless
from app.logs.replay.options import ReplayOptions
from app.program.config import Configuration
from app.program.system import System

#: A module's first work (imports, tables for a camera's lens, first allocations) is none of its cost: each instance is
#: given one message before anything is measured, within so much of the log (s).
WARM_UP_S = 1.0


class Bench:
    """Measures modules of the program ``configuration`` on ``log`` from ``begin`` to ``end`` (robot's clock, s).

    ``attended``: the filters (``Module.port``) that strategies name, closed where they are not measured. A module's
    events are the percepts on its first output, as configuration names them.
    """

    def __init__(
        self, log: Log, configuration: Configuration, begin: float, end: float, attended: Collection[str] = ()
    ) -> None:
        self._log = log
        self._configuration = configuration
        #: Begin and end (s) of the measurement.
        self.begin = max(begin, log.info.begin + WARM_UP_S)
        self.end = end
        self._attended = frozenset(attended)

    def measure(self, runs: Sequence[Run], progress: Callable[[float], None] = lambda _: None) -> list[Measurement]:
        """Make ``runs``, all of one module, in one replay, as fast as the machine allows.

        ``progress`` is called with the share done. Raises ConfigError, LogError, LinkFailed.
        """
        program = batch_program(self._configuration, runs, self._attended)
        before = self.begin - WARM_UP_S
        events: Counter[str | None] = Counter()
        warmed: dict[str, float] = {}

        def count(channel: str, message: Any) -> None:
            if warmed and channel in counted:
                events[channel] += percepts(message)

        async def warm_up(system: System) -> None:
            """Note what each instance had cost when all were warm."""
            meters = {name: system.graph.modules[name].context.meter for name in program.names}
            cold = {name: meter.cpu_ns for name, meter in meters.items()}
            await system.clock.sleep_until(self.begin)
            warmed.update({name: (meter.cpu_ns - cold[name]) / 1e9 for name, meter in meters.items()})
            program.begin(system.graph.filters)

        counted = frozenset(program.events)
        options = ReplayOptions(
            begin=before,
            end=self.end,
            pins=program.pins,
            parameters=program.parameters,
            config=program.configuration,
            desires=False,
        )
        watch = ReplayWatch(
            progress=lambda position: progress((position - before) / (self.end - before)),
            message=count,
            built=serialize_computing,
            beside=warm_up,
        )
        report = run_headless(self._log, options, watch=watch, digests=False)
        return [
            Measurement(report.modules[name].cpu_s - warmed[name], events[channel], self.end - self.begin)
            for name, channel in zip(program.names, program.events, strict=True)
        ]


def percepts(message: Any) -> int:
    """Number of percepts in a message: the entries of its one tuple of percepts, else 1."""
    kind: Any = type(message)
    name = _percepts_field(kind)
    return 1 if name is None else len(getattr(message, name))


@cache
def _percepts_field(message_type: Any) -> str | None:
    """The field of ``message_type`` that is a tuple of dataclasses, such as ``faces``; None where there is not one."""
    found = []
    for name, kind in get_type_hints(message_type).items():
        entry, *rest = get_args(kind) or (None,)
        if get_origin(kind) is tuple and rest == [...] and is_dataclass(entry):
            found.append(name)
    return found[0] if len(found) == 1 else None
