"""The robot drives among people while its costs are wrong, a module becomes dear, and half of its core is taken away.

Each run is made twice, with the loop open and closed. The program is kept on one core, the world on the others.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import tempfile
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import psutil
import yaml

from app.attention.calibration import RESOURCE
from app.attention.desires import Source
from app.attention.strategies import CLOSED
from app.base.geometry import Pose2
from app.base.yaml_source import load_yaml
from app.experiments.closed_loop.dear_module import DearMeter
from app.experiments.closed_loop.result import Phase, RunResult, Sample
from app.experiments.overload.confinement import confined, shared
from app.experiments.simulated import SimulatedProgram, simulated_program
from app.messages import LinkStatus, Twist
from app.program.config import ClosedLoopConfig
from app.program.system import System
from app.robots.config import RobotConfig

#: Time (s) before the measurement, for all modules to start.
SETTLE_S: Final = 4.0
_SAMPLE_S: Final = 0.5
_ME: Final = Source("operator", "the experiment")
_DESIRES: Final = ("FindQRCodes", "LocateFaces", "LocateVoices", "DetectNoises", "Telepresence", "SLAM")
#: The module that becomes dear, and its factor.
DEAR, FACTOR = "FaceDetector", 2.0
WRONG: Final = 3.0
#: Where the robot begins in the world, and where it goes to and fro, in its map (m, rad): along the long corridor.
START: Final = Pose2(3.5, 7.9, 0.0)
_GOALS: Final = ((6.0, 0.0, 0.0), (1.0, 0.0, math.pi))

OnProgress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True)
class LoopPlan:
    """The program in its world, and the length (s) of each phase."""

    program: SimulatedProgram
    phase_s: float


def plan(config: Path | None, scenario: Path | None, phase_s: float) -> LoopPlan:
    """Read everything. Raises ConfigError."""
    program = simulated_program(config, scenario)
    return LoopPlan(replace(program, body=_starting(program.body)), phase_s)


def run(what: LoopPlan, on_progress: OnProgress) -> tuple[RunResult, ...]:
    """All runs. ``on_progress(name, share)`` reports progress in [0, 1]. Raises LinkFailed, ConfigError."""
    runs = [(kind, closed) for kind in ("too low", "too high", "load") for closed in (False, True)]
    results = []
    for number, (kind, closed) in enumerate(runs):

        def report(part: float, number: int = number, kind: str = kind, closed: bool = closed) -> None:
            on_progress(f"{kind}, {'closed' if closed else 'open'}", (number + part) / len(runs))

        with tempfile.TemporaryDirectory() as folder:
            program = program_of(what.program, kind, closed, Path(folder))
            results.append(asyncio.run(_run(program, kind, closed, what.phase_s, report)))
    return tuple(results)


def scaled(data: Any, factor: float) -> Any:
    """A file of strategies with ``factor`` times the CPU in all costs."""
    for entry in (*data.get("strategies", ()), *data.get("families", ())):
        if RESOURCE in entry.get("costs", {}):
            entry["costs"][RESOURCE] = _scaled(entry["costs"][RESOURCE], factor)
    return data


def _scaled(cost: Any, factor: float) -> Any:
    if isinstance(cost, dict):
        return {key: _scaled(value, factor) for key, value in cost.items()}
    return round(cost * factor, 3)


def _starting(body: RobotConfig) -> RobotConfig:
    start = body.start.model_copy(update={"x": START.x, "y": START.y, "heading_deg": math.degrees(START.theta)})
    return body.model_copy(update={"start": start})


def program_of(program: SimulatedProgram, kind: str, closed: bool, folder: Path) -> SimulatedProgram:
    """``program`` for a run of ``kind``: its loop, and costs that are declared wrong, in files in ``folder``."""
    configuration = program.configuration
    attention = configuration.program.attention
    attention = attention.model_copy(update={"closed_loop": ClosedLoopConfig() if closed else None})
    update: dict[str, Any] = {"attention": attention}
    factor = {"too low": 1 / WRONG, "too high": WRONG}.get(kind)
    if factor is not None:
        files = []
        for number, file in enumerate(configuration.program.strategies):
            data = scaled(load_yaml(configuration.path(file)).data, factor)
            files.append(folder / f"{number}.yaml")
            files[-1].write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
        update["strategies"] = tuple(files)
    changed = configuration.program.model_copy(update=update)
    # What this computer was calibrated for would set costs right.
    return replace(program, configuration=replace(configuration, program=changed, calibration=None))


def phases_of(kind: str, phase_s: float) -> tuple[Phase, ...]:
    """The phases of a run of ``kind``, one after the other."""
    names = ("as it is", "a module costs twice", "half taken", "given back") if kind == "load" else (f"costs {kind}",)
    return tuple(Phase(name, n * phase_s, (n + 1) * phase_s) for n, name in enumerate(names))


async def _run(
    program: SimulatedProgram, kind: str, closed: bool, phase_s: float, on_progress: Callable[[float], None]
) -> RunResult:
    system, link = program.system()
    slot = system.graph.modules[DEAR]
    dear = slot.context.meter = DearMeter(slot.context.meter)
    phases = phases_of(kind, phase_s)
    async with system:
        assert link.process_id is not None
        with confined(link.process_id, 100.0):
            if kind == "load":
                await system.clock.sleep(SETTLE_S)
            for cls in _DESIRES:
                if cls in system.classes:
                    system.workspace.add(cls, intensity=4, utility=1, source=_ME)
            watch = _Watch(system)
            driving = asyncio.create_task(_to_and_fro(system), name="to and fro")
            try:
                for phase in phases:
                    dear.factor = FACTOR if phase.name == "a module costs twice" else 1.0
                    with shared(50.0) if phase.name == "half taken" else contextlib.nullcontext():
                        async for t in watch.until(phase.ends):
                            on_progress(t / phases[-1].ends)
            finally:
                driving.cancel()
                await asyncio.wait({driving})
                watch.end()
            return watch.result(kind, closed, phases)


async def _to_and_fro(system: System) -> None:
    """Drive to one place after the other, for ever; what cannot be reached is left for the next."""
    while True:
        for x, y, heading in _GOALS:
            params = {"x": x, "y": y, "heading": heading}
            desire = system.workspace.add("GoTo", intensity=8, utility=1, params=params, source=_ME)
            while any(each.id == desire.id for each in system.workspace.desires()):
                await system.clock.sleep(_SAMPLE_S)


class _Watch:
    """Samples a running program."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._began = system.clock.now()
        self._samples: list[Sample] = []
        self._periods: list[float] = []
        self._last: float | None = None
        self._rates: list[float] = []
        self._process = psutil.Process()
        self._spent = self._busy()
        self._cpu = self._began, self._counts()
        self._ends = [
            system.graph.channels["path_twist"].observe(self._command),
            system.link.attach("status", self._status),
        ]

    async def until(self, ends: float) -> AsyncIterator[float]:
        """Sample until ``ends`` (s since the begin); gives the time after each."""
        while (t := self._system.clock.now() - self._began) < ends:
            await self._system.clock.sleep(_SAMPLE_S)
            self._sample()
            yield t

    def end(self) -> None:
        """Stop watching."""
        for end in self._ends:
            end()

    def result(self, kind: str, closed: bool, phases: tuple[Phase, ...]) -> RunResult:
        """What was seen."""
        states = self._system.supervisor.states.values()
        seconds = self._system.clock.now() - self._began
        ours, all_ = (now - then for now, then in zip(self._busy(), self._spent, strict=True))
        return RunResult(
            kind,
            closed,
            phases=phases,
            samples=tuple(self._samples),
            periods=tuple(self._periods),
            restarts=sum(state.restarts for state in states),
            others=100 * max(0.0, all_ - ours) / seconds,
            world_rate=sum(self._rates) / len(self._rates) if self._rates else math.nan,
        )

    def _sample(self) -> None:
        system = self._system
        current = system.translator.current
        now, counts = system.clock.now(), self._counts()
        at_work = () if current is None else current.strategies
        modules = {
            name.partition(".")[0]
            for s in at_work
            if s.costs.get(RESOURCE, 0) > 0
            for name, phi in s.filters.items()
            if phi != CLOSED
        }
        then, before = self._cpu
        used = sum(1e-7 * (counts[name] - before[name]) / (now - then) for name in modules)
        self._cpu = now, counts
        loop = None if system.control is None else system.control.report()
        self._samples.append(
            Sample(
                now - self._began,
                used,
                budget=system.translator.capacities.get(RESOURCE, math.inf),
                share=1.0 if loop is None else loop.share,
                waiting=math.nan if loop is None else loop.waiting,
                divisors={
                    name: phi for s in at_work for name, phi in s.filters.items() if phi != CLOSED and s.cls in _DESIRES
                },
            )
        )

    def _counts(self) -> dict[str, int]:
        return {name: slot.context.meter.cpu_ns for name, slot in self._system.graph.modules.items()}

    def _command(self, message: Twist) -> None:
        now = self._system.clock.now()
        if self._last is not None and now - self._last < 1.0:
            self._periods.append(now - self._last)
        self._last = now

    def _status(self, status: LinkStatus) -> None:
        self._rates.append(status.world_rate)

    def _busy(self) -> tuple[float, float]:
        """CPU time (s) of the program with its world, and of all programs."""
        ours = 0.0
        for each in (self._process, *self._process.children(recursive=True)):
            with contextlib.suppress(psutil.NoSuchProcess):
                ours += sum(each.cpu_times()[:2])
        times = psutil.cpu_times()
        return ours, float(times.user + times.nice + times.system)


def rows(results: tuple[RunResult, ...]) -> Iterator[list[object]]:
    """The samples as rows of a table, the first its head."""
    yield ["run", "loop", "t_s", "used_percent", "budget_percent", "share", "waiting", "divisors"]
    for result in results:
        for s in result.samples:
            divisors = " ".join(f"{name}={phi:g}" for name, phi in sorted(s.divisors.items()))
            figures = [round(value, 3) for value in (s.t, s.used, s.budget, s.share, s.waiting)]
            yield [result.kind, "closed" if result.closed else "open", *figures, divisors]
