"""Measured cost of each module at each φ of its strategies: the plan of runs, their results, and fitted lines.

Thesis 4.2.3 and figure 4.4: each perception was run on a recording at several φ, from every starting offset; CPU use
and events were found to be close to linear in 1/φ. Here one *run* is one module alone in a headless replay, its input
pinned at one φ and one offset; many are made in one replay (``batch_replay.py``). Everything in this file is pure or a
file of results.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from statistics import median

from app.attention.calibration import CostFit, Point, Relation, relation_name
from app.attention.strategies import CLOSED, StrategyTable
from app.base.whole_file import write_whole


@dataclass(frozen=True, slots=True, order=True)
class Run:
    """One measurement to make: ``module`` alone, its input ``port`` at ``phi``, after ``offset`` messages; ``repeat``
    numbers equal measurements. ``parameters``: those of the module, as JSON."""

    module: str
    port: str
    phi: int
    offset: int = 0
    repeat: int = 0
    parameters: str = "{}"

    @property
    def filter(self) -> str:
        """``Module.port``."""
        return f"{self.module}.{self.port}"

    @property
    def relation(self) -> str:
        """The key of the relation that the run belongs to."""
        return relation_name(self.filter, json.loads(self.parameters))


@dataclass(frozen=True, slots=True)
class Measurement:
    """Result of a run: thread CPU time and number of percepts over ``duration_s`` of the recording."""

    cpu_s: float
    events: int
    duration_s: float

    @property
    def cpu(self) -> float:
        """% of one core, had the recording passed in real time."""
        return 100 * self.cpu_s / self.duration_s

    @property
    def rate(self) -> float:
        """Events a second."""
        return self.events / self.duration_s


def plan(
    table: StrategyTable,
    inputs: Mapping[str, Collection[str]],
    *,
    every_offset: bool = False,
    repeats: int = 1,
    sweep: Mapping[str, Collection[int]] | None = None,
) -> list[Run]:
    """The runs for the strategies of ``table``: each filtered input at each of its divisors, ascending, with each set
    of parameters that a strategy sets for its module.

    ``inputs`` maps each module to be measured to its input ports (outputs cost nothing to decimate). With
    ``every_offset``, each φ is measured from each of its φ starting offsets, as the thesis did. The whole plan is
    repeated ``repeats`` times, so that other load on the computer does not affect one φ alone. ``sweep`` gives other
    divisors, for the filters in it alone, with the module's own settings.
    """
    wanted = {
        (module, port, int(divisor), json.dumps(strategy.parameters.get(module, {}), sort_keys=True))
        for strategy in table.strategies
        for name, divisor in strategy.filters.items()
        for module, _, port in [name.partition(".")]
        if divisor != CLOSED and port in inputs.get(module, ())
    }
    if sweep is not None:
        wanted = {
            (module, port, phi, "{}")
            for name, phis in sweep.items()
            for module, _, port in [name.partition(".")]
            for phi in phis
            if port in inputs.get(module, ())
        }
    return [
        Run(module, port, phi=phi, offset=offset, repeat=repeat, parameters=parameters)
        for repeat in range(repeats)
        for module, port, phi, parameters in sorted(wanted)
        for offset in range(phi if every_offset else 1)
    ]


def relations(results: Mapping[Run, Measurement]) -> dict[str, Relation]:
    """The relation of each filter (with each set of parameters), from all runs made of it."""
    found: dict[str, Relation] = {}
    for name, runs in groupby(sorted(results, key=lambda run: (run.relation, run)), key=lambda run: run.relation):
        points = [
            _point(phi, [results[run] for run in of_phi]) for phi, of_phi in groupby(runs, key=lambda run: run.phi)
        ]
        found[name] = Relation(
            points=tuple(points),
            cpu=fit([(p.phi, p.cpu) for p in points]),
            events=fit([(p.phi, p.events) for p in points]),
        )
    return found


def _point(phi: int, measurements: Sequence[Measurement]) -> Point:
    cpu = [m.cpu for m in measurements]
    return Point(
        phi=phi,
        cpu=round(median(cpu), 4),
        events=round(math.fsum(m.rate for m in measurements) / len(cpu), 4),
        runs=len(cpu),
        cpu_spread=round(max(cpu) - min(cpu), 4),
    )


def fit(points: Iterable[tuple[float, float]]) -> CostFit:
    """The line ``base + slope / φ`` with the least squared distances from ``points`` (φ, value).

    Through one point alone (or several of one φ), the value is taken as proportional to 1/φ.
    """
    points = list(points)
    xs = [1 / phi for phi, _ in points]
    ys = [value for _, value in points]
    n = len(points)
    mean_x, mean_y = math.fsum(xs) / n, math.fsum(ys) / n
    spread = math.fsum((x - mean_x) ** 2 for x in xs)
    if spread < 1e-12:
        base, slope = 0.0, mean_y / mean_x
    else:
        slope = math.fsum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys, strict=True)) / spread
        base = mean_y - slope * mean_x
    squares = math.fsum((base + slope * x - y) ** 2 for x, y in zip(xs, ys, strict=True))
    return CostFit(base=round(base, 5), slope=round(slope, 5), residual=round(math.sqrt(squares / n), 5))


class CalibrationProgress:
    """Results so far, on disk after every batch, so that an interrupted calibration can continue.

    ``key`` identifies the recording, program and version: results of another key are not used.
    """

    def __init__(self, path: Path, key: Mapping[str, object]) -> None:
        self._path = path
        self._key = dict(key)
        self.results: dict[Run, Measurement] = {}

    def load(self) -> int:
        """Read the results on disk; returns their number."""
        try:
            content = json.loads(self._path.read_text(encoding="utf-8"))
            if content["key"] == self._key:
                self.results = {Run(**entry["run"]): Measurement(**entry["result"]) for entry in content["results"]}
        except (OSError, ValueError, KeyError, TypeError):
            self.results = {}  # none, or of another calibration: measure again
        return len(self.results)

    def add(self, results: Mapping[Run, Measurement]) -> None:
        """Remember results, on disk too; a file half written is never left."""
        self.results.update(results)
        entries = [{"run": asdict(r), "result": asdict(m)} for r, m in self.results.items()]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, json.dumps({"key": self._key, "results": entries}, indent=1).encode())

    def discard(self) -> None:
        """Done: the file is not needed any more."""
        self._path.unlink(missing_ok=True)


def measure_all(
    runs: Sequence[Run],
    measure: Callable[[Sequence[Run]], Sequence[Measurement]],
    progress: CalibrationProgress,
    batches: Callable[[Sequence[Run]], Sequence[Sequence[Run]]],
) -> dict[Run, Measurement]:
    """Make the runs that ``progress`` does not have yet, in order and in ``batches``; the results of all ``runs``."""
    for batch in batches([run for run in runs if run not in progress.results]):
        progress.add(dict(zip(batch, measure(batch), strict=True)))
    return {run: progress.results[run] for run in runs}
