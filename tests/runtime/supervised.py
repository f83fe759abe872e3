"""A module that does what its plan says, under the supervisor, and what was seen of it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping
from typing import Any

from app.messages import Twist
from app.runtime.clock import VirtualClock
from app.runtime.errors import ModuleFailed
from app.runtime.graph import Graph
from app.runtime.module import Module, ModuleContext
from app.runtime.supervisor import ModuleState, Supervisor

Build = Callable[..., Graph]
Make = Callable[..., Twist]


class Plan:
    """A service: what the modules under test shall do, and what they did."""

    def __init__(self) -> None:
        self.events: list[tuple[float, Any]] = []
        self.fail_start = False
        self.fail_beat_at: float | None = None
        self.start_takes_s = 0.0
        self.fail_construction = False
        self.fail_stop = False
        self.fail_after_s: float | None = None
        self.hang = False
        self.cling = False
        self.slow_s = 0.0
        self.release = threading.Event()


class Subject(Module):
    """Does what its plan says."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.plan = self.service(Plan)
        if self.plan.fail_construction:
            raise ValueError("cannot be made")
        self.numbers = self.input("numbers", Twist, capacity=3, lossless=True)
        self.out = self.output("out", Twist)
        self.on(self.numbers, self.take)
        self.every(0.5, self.beat)

    def note(self, what: Any) -> None:
        self.plan.events.append((round(self.clock.now() - 1_000_000, 3), what))

    async def start(self) -> None:
        self.note("start")
        self.began = self.clock.now()
        if self.plan.start_takes_s:
            await self.clock.sleep(self.plan.start_takes_s)
        if self.plan.fail_start:
            raise ModuleFailed("plug the camera in")

    async def stop(self) -> None:
        self.note("stop")
        if self.plan.fail_stop:
            raise OSError("cannot let go")

    def configure(self, parameters: Mapping[str, Any]) -> None:
        if parameters:
            self.note(dict(parameters))

    async def take(self, message: Twist) -> None:
        if message.linear_mps < 0:
            raise ZeroDivisionError("a bad message")
        if self.plan.cling:
            self.plan.cling = False
            try:
                await asyncio.sleep(1e6)
            except asyncio.CancelledError:
                await asyncio.sleep(2)  # will not go
                return
        if self.plan.hang:
            self.plan.hang = False
            await asyncio.get_running_loop().create_future()
        self.note(message.linear_mps)
        self.out.publish(message)
        await self.clock.sleep(self.plan.slow_s)

    async def beat(self) -> None:
        if self.plan.fail_after_s is not None and self.clock.now() - self.began >= self.plan.fail_after_s - 1e-6:
            raise RuntimeError("worn out")


class Steady(Module):
    """Publishes ten numbers a second, whatever happens to the others."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.output("numbers", Twist)
        self.every(0.1, self.beat)

    async def beat(self) -> None:
        self.numbers.publish(Twist(self.clock.now(), 1.0, 0.0))


class Bench:
    """A subject fed through channel ``n``, a steady module beside it, and what was seen of both."""

    def __init__(self, build: Build, plan: Plan | None = None, **spec: Any) -> None:
        self.plan = plan or Plan()
        self.graph = build(
            {
                "S": (Subject, {"numbers": "n"}, {"out": "o"}, spec),
                "Steady": (Steady, {}, {"numbers": "steady"}),
            },
            {"n": {"external": True}, "o": {}, "steady": {}},
            services={Plan: self.plan},
        )
        self.clock = VirtualClock()
        self.supervisor = Supervisor(self.graph.modules, self.clock)
        self.seen: list[ModuleState] = []
        self.supervisor.observe(self.seen.append)

    @property
    def statuses(self) -> list[tuple[float, str]]:
        return [(round(s.since - 1_000_000, 3), s.status) for s in self.seen if s.name == "S"]

    @property
    def state(self) -> ModuleState:
        return self.supervisor.states["S"]

    @property
    def status(self) -> str:
        return self.state.status

    @property
    def stale(self) -> bool:
        return self.state.stale

    def publish(self, message: Twist) -> None:
        self.graph.channels["n"].publish(message)


class Computes(Module):
    """Computes on every message; the first computation never comes back until the plan releases it."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.plan = self.service(Plan)
        self.numbers = self.input("numbers", Twist)
        self.on(self.numbers, self.take)

    async def take(self, message: Twist) -> None:
        self.plan.events.append((message.linear_mps, await self.compute(self.work, message.linear_mps)))

    def work(self, value: float) -> str:
        if value == 1:
            self.plan.release.wait()
        return threading.current_thread().name
