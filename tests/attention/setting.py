"""A translator with filters, parameters and a timeline to look at, for its tests."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable, Collection, Mapping
from contextlib import asynccontextmanager
from typing import Any

from pydantic import BaseModel

from app.attention.cached_solver import CachedSolver
from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.problem import Selection, SelectionProblem
from app.attention.strategies import Resource, Strategy, StrategyTable
from app.attention.timeline import Timeline
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.runtime.clock import VirtualClock
from tests.attention.thesis import TABLE_4_4

ME = Source("operator", "console")
TABLE = StrategyTable(TABLE_4_4, {"cpu": Resource("cpu", 100, "% of one core")})
#: Two classes that want the same wheels.
RIVALS = StrategyTable(
    tuple(
        Strategy(name, cls, 4, filters={f"{name}.x": 1}, costs={"wheels": 1})
        for name, cls in (("goto", "GoTo"), ("teleop", "Teleoperation"))
    ),
    {"wheels": Resource("wheels", 1)},
)


class Goal(BaseModel):
    x: float = 0.0


CLASSES = DesireClasses(DesireClass(name, name, "", Goal) for name in TABLE.classes)


class Bank:
    """Filters as the runtime's bank keeps them, remembering every call."""

    def __init__(self, names: Collection[str]) -> None:
        self.phi = dict.fromkeys(names, math.inf)
        self.calls: list[dict[str, float]] = []

    def names(self) -> Collection[str]:
        return self.phi.keys()

    def apply(self, divisors: Mapping[str, float]) -> None:
        self.calls.append(dict(divisors))
        self.phi.update(divisors)


class Sink:
    def __init__(self) -> None:
        self.calls: list[tuple[str, dict[str, Any]]] = []

    def configure(self, module: str, parameters: Mapping[str, Any]) -> None:
        self.calls.append((module, dict(parameters)))


class Setting:
    def __init__(self, table: StrategyTable = TABLE, classes: DesireClasses = CLASSES, **options: Any) -> None:
        self.clock = VirtualClock()
        self.workspace = IntentionWorkspace(classes, self.clock.now)
        self.bank = Bank(table.filters | {"Kinect.images"})
        self.sink = Sink()
        self.timeline = Timeline(1000, self.clock.now)
        self.translator = IntentionTranslator(
            self.workspace, table, self.bank, self.sink, self.timeline, self.clock, **options
        )

    def add(self, cls: str, intensity: float = 8, utility: float = 1, **more: Any) -> str:
        return self.workspace.add(cls, intensity=intensity, utility=utility, source=ME, **more).id

    @property
    def selected(self) -> tuple[str, ...]:
        assert self.translator.current is not None
        return self.translator.current.selection.strategies

    def events(self, kind: str) -> list[str]:
        return [e.subject for e in self.timeline.query(kinds={kind})]

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        task = asyncio.create_task(self.translator.run())
        try:
            yield
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)


class HeldSolver(CachedSolver):
    """Answers when a test resolves the future; ``waiting`` holds the problems with their futures."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting: list[tuple[SelectionProblem, asyncio.Future[None]]] = []
        self.asked = asyncio.Event()

    def recall(self, problem: SelectionProblem) -> Selection | None:
        return None

    async def offload(self, function: Callable[..., Any], *arguments: Any) -> Any:
        if function == self.solve:
            future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self.waiting.append((arguments[0], future))
            self.asked.set()
            await future
        return function(*arguments)

    async def next(self) -> tuple[SelectionProblem, asyncio.Future[None]]:
        while not self.waiting:
            self.asked.clear()
            await self.asked.wait()
        return self.waiting.pop(0)
