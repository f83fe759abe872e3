from __future__ import annotations

import asyncio
import io
import threading
import time
from collections.abc import Callable

import pytest

from app.messages import Twist
from app.runtime.clock import VirtualClock, in_virtual_time, run_virtual
from app.runtime.graph import Graph
from app.runtime.load import CpuMeter, LoadMeter, MeteredCoroutine
from app.runtime.module import Module, ModuleContext
from app.runtime.supervisor import Supervisor

Build = Callable[..., Graph]

WORK_NS = 20_000_000


def burn() -> None:
    """Use 20 ms of this thread's CPU time."""
    until = time.thread_time_ns() + WORK_NS
    while time.thread_time_ns() < until:
        pass


class OnTheLoop(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.input("numbers", Twist)
        self.on(self.numbers, self.take)

    async def take(self, message: Twist) -> None:
        burn()
        await asyncio.sleep(0)
        burn()


class InAThread(OnTheLoop):
    async def take(self, message: Twist) -> None:
        await self.compute(burn)
        await self.compute(burn)


class Idle(OnTheLoop):
    async def take(self, message: Twist) -> None:
        pass


@in_virtual_time
async def test_each_module_is_charged_what_it_spends_on_the_loop_and_in_its_thread(build: Build) -> None:
    graph = build(
        {name: (cls, {"numbers": "n"}, {}) for name, cls in {"L": OnTheLoop, "T": InAThread, "I": Idle}.items()},
        {"n": {"external": True}},
    )
    meters = {name: slot.context.meter for name, slot in graph.modules.items()}
    async with Supervisor(graph.modules, graph.clock):
        await asyncio.sleep(1)
        load = LoadMeter(meters, graph.clock.now)
        before = {name: meter.cpu_ns for name, meter in meters.items()}
        graph.channels["n"].publish(Twist(0.0, 0.0, 0.0))
        await asyncio.sleep(1)
        spent = {name: meter.cpu_ns - before[name] for name, meter in meters.items()}
        sampled = load.sample()
    for name in ("L", "T"):
        assert 2 * WORK_NS <= spent[name] < 3 * WORK_NS
    assert spent["I"] < WORK_NS / 2
    assert sampled.modules["L"] == pytest.approx(100 * spent["L"] / (sampled.window_s * 1e9), rel=0.2)
    assert sampled.process >= sampled.modules["L"] + sampled.modules["T"] - 1
    assert load.latest is sampled


def test_a_window_starts_where_the_last_one_ended() -> None:
    meter = CpuMeter()
    load = LoadMeter({"M": meter}, VirtualClock().now)
    assert load.latest.modules == {"M": 0.0}
    meter.step(burn)
    assert load.sample().modules["M"] > 1
    assert load.sample().modules["M"] == 0


def test_threads_that_charge_at_the_same_time_lose_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    # Each call costs exactly 1 ns by this clock.
    readings = threading.local()

    def clock() -> int:
        readings.value = getattr(readings, "value", 0) + 1
        return int(readings.value)

    monkeypatch.setattr(time, "thread_time_ns", clock)
    meter = CpuMeter()
    calls = 20_000
    threads = [threading.Thread(target=lambda: [meter.call(int) for _ in range(calls)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(calls):
        meter.step(int)
    for thread in threads:
        thread.join()
    assert meter.cpu_ns == 5 * calls


def test_the_meter_knows_whose_step_it_is() -> None:
    meter, other = CpuMeter(), CpuMeter()
    seen: list[tuple[bool, bool]] = []

    async def step() -> None:
        seen.append((meter.stepping, other.stepping))
        await asyncio.sleep(0)
        seen.append((meter.stepping, other.stepping))

    async def scenario() -> None:
        task = asyncio.create_task(MeteredCoroutine(step(), meter))
        await asyncio.sleep(0)
        assert not meter.stepping
        await task

    run_virtual(scenario())
    assert seen == [(True, False), (True, False)]


@in_virtual_time
async def test_a_metered_coroutine_behaves_as_the_one_inside() -> None:
    meter = CpuMeter()

    async def body(value: int) -> int:
        await asyncio.sleep(1)
        if value < 0:
            raise ValueError("negative")
        return value

    assert await MeteredCoroutine(body(3), meter) == 3
    task: asyncio.Task[int] = asyncio.create_task(MeteredCoroutine(body(4), meter), name="named")
    assert "named" in repr(task)
    task.print_stack(file=io.StringIO())
    assert await task == 4
    with pytest.raises(ValueError, match="negative"):
        await asyncio.create_task(MeteredCoroutine(body(-1), meter))
    cancelled = asyncio.create_task(MeteredCoroutine(body(5), meter))
    await asyncio.sleep(0.5)
    cancelled.cancel()
    with pytest.raises(asyncio.CancelledError):
        await cancelled
    never_begun = MeteredCoroutine(body(6), meter)
    never_begun.close()
