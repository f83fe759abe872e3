"""What is hung, and what only waits; what becomes of a module that is, and of what outlives its end."""

from __future__ import annotations

import asyncio
import threading

import pytest

from app.runtime.clock import VirtualClock, in_virtual_time, run_virtual
from app.runtime.supervisor import Supervisor
from tests.runtime.supervised import Bench, Build, Computes, Make, Plan, Steady


@in_virtual_time
async def test_a_hung_handler_is_reported_cancelled_and_restarted(build: Build, make: Make) -> None:
    bench = Bench(build)
    bench.plan.hang = True
    async with bench.supervisor:
        await asyncio.sleep(1)
        bench.publish(make(1))
        await asyncio.sleep(5)
        assert bench.status == "running", "nothing waits: it may take as long as it likes"
        bench.publish(make(2))
        await asyncio.sleep(1.3)
        assert bench.status == "hung"
        assert bench.stale
        assert bench.state.problem.startswith("messages wait at numbers and none was taken for 1.")
        await asyncio.sleep(1)
    assert bench.plan.events[1:3] == [(7.2, "stop"), (7.7, "start")]
    assert (7.7, 2.0) in bench.plan.events, "what waited is served by the new instance"


@in_virtual_time
async def test_of_modules_that_are_glanced_at_in_turns_the_hung_one_is_found(
    build: Build, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its turn comes within as many looks as there are turns: here some tenths of a second later."""
    monkeypatch.setattr("app.runtime.supervisor.GLANCE", 1)
    bench = Bench(build)
    bench.plan.hang = True
    async with bench.supervisor:
        await asyncio.sleep(1)
        bench.publish(make(1))
        await asyncio.sleep(5)
        assert bench.status == "running"
        bench.publish(make(2))
        await asyncio.sleep(2)
        assert next(what for at, what in bench.plan.events if at > 6.0) == "stop"


@in_virtual_time
async def test_the_declared_time_decides_what_is_hung(build: Build, make: Make) -> None:
    bench = Bench(build, hang_after_s=20)
    bench.plan.hang = True
    async with bench.supervisor:
        bench.publish(make(1))
        await asyncio.sleep(0.5)
        bench.publish(make(2))
        await asyncio.sleep(19)
        assert bench.status == "running"
        await asyncio.sleep(1.4)
        assert bench.status == "hung"


class StuckTimer(Steady):
    async def beat(self) -> None:
        if self.clock.now() > 1_000_005:
            await asyncio.get_running_loop().create_future()
        await super().beat()


@in_virtual_time
async def test_a_timer_that_does_not_come_round_is_hung(build: Build) -> None:
    graph = build({"T": (StuckTimer, {}, {"numbers": "n"})}, {"n": {}})
    supervisor = Supervisor(graph.modules, graph.clock)
    async with supervisor:
        await asyncio.sleep(6.05)
        assert str(supervisor.states["T"].status) == "running"
        await asyncio.sleep(0.2)
        assert str(supervisor.states["T"].status) == "hung"
        assert "its periodic beat-0 did not come round" in supervisor.states["T"].problem


def test_a_stuck_thread_is_abandoned_and_the_module_gets_another(build: Build, make: Make) -> None:
    plan = Plan()

    async def scenario() -> None:
        graph = build({"C": (Computes, {"numbers": "n"}, {})}, {"n": {"external": True}}, services={Plan: plan})
        async with Supervisor(graph.modules, graph.clock) as supervisor:
            await asyncio.sleep(0.1)
            graph.channels["n"].publish(make(1))
            await asyncio.sleep(0.1)
            graph.channels["n"].publish(make(2))
            await asyncio.sleep(1.2)
            assert str(supervisor.states["C"].status) == "hung"
            await asyncio.sleep(1)
            assert str(supervisor.states["C"].status) == "running"

    stuck_before = threading.active_count()
    try:
        run_virtual(scenario(), patience_s=0.05)
        assert plan.events == [(2, "module C")]
        assert threading.active_count() >= stuck_before, "the stuck one is still there, and held nothing up"
    finally:
        plan.release.set()


@in_virtual_time
async def test_a_slow_start_is_not_taken_for_a_hang(build: Build, make: Make) -> None:
    bench = Bench(build)
    bench.plan.start_takes_s = 5
    async with bench.supervisor:
        bench.publish(make(1))
        await asyncio.sleep(4.9)
        assert bench.status == "starting"
        await asyncio.sleep(1)
        assert bench.status == "running"
        assert bench.state.restarts == 0
    assert (5, 1.0) in bench.plan.events


@in_virtual_time
async def test_a_start_that_never_ends_is_hung(build: Build) -> None:
    bench = Bench(build, start_within_s=3)
    bench.plan.start_takes_s = 1e9
    async with bench.supervisor:
        await asyncio.sleep(3.3)
        assert bench.status == "hung"
        assert bench.state.problem == "did not start within 3 s"


@in_virtual_time
async def test_a_restarted_module_is_not_blamed_for_what_waited_while_it_was_down(build: Build, make: Make) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(0.5)
        bench.plan.start_takes_s = 3
        bench.publish(make(-1))
        bench.publish(make(1))
        await asyncio.sleep(10)
        assert bench.state.restarts == 1
        assert bench.status == "running"


@in_virtual_time
async def test_what_outlives_its_cancellation_neither_takes_nor_publishes_any_more(
    build: Build, make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(build)
    bench.plan.cling = True
    async with bench.supervisor:
        await asyncio.sleep(1)
        for value in (1, 2):
            bench.publish(make(value))
        await asyncio.sleep(2.2)
        assert "S does not end 0.5 s after it was cancelled; left behind" in caplog.text
        await asyncio.sleep(0.5)
        assert bench.status == "running"
        published = bench.graph.channels["o"].statistics().published
        assert published == 1, "message 2, by the new instance"
        await asyncio.sleep(1.5)  # the old one comes back to life
        assert (bench.plan.events[-1][1], bench.graph.channels["o"].statistics().published) == ("stop", published)
        for value in (3, 4, 5):
            bench.publish(make(value))
        await asyncio.sleep(0.1)
        assert bench.graph.channels["o"].statistics().published == published + 3


@in_virtual_time
async def test_what_outlives_its_cancellation_steals_nothing_from_a_busy_successor(build: Build, make: Make) -> None:
    bench = Bench(build, hang_after_s=3)
    bench.plan.cling = True
    async with bench.supervisor:
        for value in (1, 2):
            bench.publish(make(value))
        await asyncio.sleep(4.5)
        assert bench.status == "running"
        bench.plan.slow_s = 2.0
        for value in (3, 4, 5):
            bench.publish(make(value))
        await asyncio.sleep(2.4)  # the old one comes back to life while the new one works on message 3
        served = bench.graph.channels["n"].statistics().subscriptions["S.numbers"].taken
        published = bench.graph.channels["o"].statistics().published
        assert (served, published) == (4, 3), "1 by the old one; 2, 3 and 4 by the new one"


class Paced(VirtualClock):
    """A robot's clock that reads ``rate`` times the virtual time."""

    rate = 1.0

    def now(self) -> float:
        return self.origin + self.rate * (super().now() - self.origin)

    async def sleep(self, seconds: float) -> None:
        await super().sleep(seconds / self.rate if self.rate else 1e6)


@pytest.mark.parametrize(("rate", "hung"), [(0.0, False), (0.1, False), (1.0, True), (20.0, True)])
def test_a_module_is_hung_by_the_time_it_was_given(build: Build, make: Make, rate: float, hung: bool) -> None:
    """Modules get as much time as both clocks passed: a paused or slow recording gives less, a fast one no more."""

    async def scenario() -> tuple[str, str]:
        bench = Bench(build)
        bench.plan.hang = True
        clock = Paced()
        clock.rate = rate
        supervisor = Supervisor(bench.graph.modules, clock, bench.clock)
        async with supervisor:
            bench.publish(make(1))
            await asyncio.sleep(0.1)
            bench.publish(make(2))
            await asyncio.sleep(0.8)
            early = str(supervisor.states["S"].status)
            # It is restarted after half a second of the robot's clock, which may be very short.
            seen: list[str] = []
            supervisor.observe(lambda state: seen.append(state.status))
            await asyncio.sleep(1.0)
        return early, "hung" if "hung" in seen else "running"

    assert run_virtual(scenario()) == ("running", "hung" if hung else "running")
