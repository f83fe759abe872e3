"""One run of a calibration: a headless replay of one module alone, its CPU time and its percepts counted."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

from app.config import Configuration
from app.recording.log import Log
from app.replay.calibration import Measurement, Run
from app.replay.headless import Watch, run_headless
from app.replay.options import ReplayOptions

#: A module's first work of its life (imports, first allocations) is none of its cost: so much of the log (s) is run
#: before anything is measured.
WARM_UP_S = 2.0


class Bench:
    """Measures modules of the program ``configuration`` on ``log`` from ``begin`` to ``end`` (robot's clock, s).

    A module's events are the percepts on its first output, as configuration names them.
    """

    def __init__(self, log: Log, configuration: Configuration, begin: float, end: float) -> None:
        self._log = log
        self._configuration = configuration
        self._begin = begin
        self._end = end
        self._warm: set[str] = set()

    def measure(self, run: Run) -> Measurement:
        """Replay, as fast as the machine allows. Raises ConfigError, LogError, LinkFailed."""
        if run.module not in self._warm:
            self._warm.add(run.module)
            self._replay(run, min(self._end, self._begin + WARM_UP_S))
        return self._replay(run, self._end)

    def _replay(self, run: Run, end: float) -> Measurement:
        found_on = next(iter(self._configuration.program.modules[run.module].outputs.values()), None)
        events = 0

        def count(channel: str, message: Any) -> None:
            nonlocal events
            if channel == found_on:
                events += percepts(message)

        options = ReplayOptions(
            begin=self._begin,
            end=end,
            only=(run.module,),
            phi={run.filter: run.phi},
            parameters={run.module: json.loads(run.parameters)},
            offset=run.offset,
            config=Path(self._configuration.program_document.file),
            desires=False,
        )
        report = run_headless(self._log, options, watch=Watch(message=count), digests=False)
        return Measurement(cpu_s=report.modules[run.module].cpu_s, events=events, duration_s=report.log_s)


def percepts(message: Any) -> int:
    """How many percepts a message tells of: the entries of its one tuple, or itself."""
    tuples = [value for field in fields(message) if isinstance(value := getattr(message, field.name), tuple)]
    return len(tuples[0]) if len(tuples) == 1 else 1
