from __future__ import annotations

import asyncio
import importlib
import itertools
import logging
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from app.messages import Twist
from app.runtime.clock import RealClock, VirtualClock, in_virtual_time, run_virtual
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED
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


@in_virtual_time
async def test_modules_start_run_and_stop_leaving_no_task(build: Build) -> None:
    bench = Bench(build)
    before = asyncio.all_tasks()
    async with bench.supervisor:
        assert bench.stale, "nothing has started yet"
        await asyncio.sleep(1)
        assert (bench.status, bench.state.stale) == ("running", False)
    assert bench.statuses == [(0, "starting"), (0, "running"), (1, "stopped")]
    assert bench.plan.events == [(0, "start"), (1, "stop")]
    assert asyncio.all_tasks() == before


@in_virtual_time
async def test_a_module_that_always_fails_is_restarted_after_ever_longer_delays(
    build: Build, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(build)
    bench.plan.fail_start = True
    async with bench.supervisor:
        await asyncio.sleep(130)
    starts = [stamp for stamp, what in bench.plan.events if what == "start"]
    delays = [round(after - before, 3) for before, after in itertools.pairwise(starts)]
    assert delays == [0.5, 1, 2, 4, 8, 16, 30, 30, 30]
    assert bench.plan.events.count((0, "stop")) == 1, "a start that fails is stopped too"
    assert bench.state.restarts == 9
    assert bench.state.problem == "plug the camera in"
    assert "S failed: plug the camera in; restarting in 0.5 s" in caplog.text


@in_virtual_time
async def test_the_others_keep_their_rate_while_one_fails(build: Build) -> None:
    bench = Bench(build)
    bench.plan.fail_start = True
    async with bench.supervisor:
        await asyncio.sleep(10.05)
        assert bench.graph.channels["steady"].statistics().published == 101
        assert bench.supervisor.states["Steady"].restarts == 0


@in_virtual_time
async def test_a_module_that_ran_for_a_minute_is_trusted_again(build: Build) -> None:
    bench = Bench(build)
    bench.plan.fail_after_s = 10
    async with bench.supervisor:
        await asyncio.sleep(25)
        bench.plan.fail_after_s = 61
        await asyncio.sleep(200)
    starts = [stamp for stamp, what in bench.plan.events if what == "start"]
    assert starts == pytest.approx([0, 10.5, 21.5, 83, 144.5, 206], abs=0.3)


@in_virtual_time
async def test_a_bad_message_costs_one_restart_and_is_not_served_twice(build: Build, make: Make) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(1)
        bench.graph.modules["S"].configure({"speed": 3})
        for value in (1, -1, 2):
            bench.publish(make(value))
        await asyncio.sleep(2)
        assert bench.status == "running"
    assert bench.plan.events == [
        (0, "start"), (1, {"speed": 3}), (1, 1.0), (1, "stop"),
        (1.5, "start"), (1.5, {"speed": 3}), (1.5, 2.0), (3, "stop"),
    ]  # fmt: skip
    assert bench.state.restarts == 1
    assert "ZeroDivisionError: a bad message (test_supervisor.py:" in bench.state.problem


@in_virtual_time
async def test_a_lossless_inbox_survives_the_death_of_its_module(
    build: Build, make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    # While it is down its inbox keeps what it holds; more is counted and reported, not held against the next one.
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(1)
        bench.publish(make(-1))
        await asyncio.sleep(0.1)
        assert bench.status == "failed"
        for value in range(5):
            await bench.graph.channels["n"].send(make(value), deadline_s=0.01)
        await asyncio.sleep(1)
        assert bench.status == "running"
        assert bench.state.restarts == 1
    assert [what for _, what in bench.plan.events if isinstance(what, float)] == [0, 1, 2]
    counters = bench.graph.channels["n"].statistics().subscriptions["S.numbers"]
    assert (counters.taken, counters.dropped) == (4, 2)
    assert "S.numbers lost 2 messages while the module was down" in caplog.text


@in_virtual_time
async def test_filters_and_parameters_written_while_it_is_down_hold_after_the_restart(build: Build, make: Make) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(1)
        bench.publish(make(-1))
        await asyncio.sleep(0.1)
        bench.graph.modules["S"].configure({"speed": 5})
        bench.graph.filters.apply({"S.numbers": CLOSED})
        await asyncio.sleep(1)
        bench.publish(make(8))
        bench.graph.filters.apply({"S.numbers": 2})
        for value in range(3):
            bench.publish(make(value))
        await asyncio.sleep(1)
    assert [what for _, what in bench.plan.events if not isinstance(what, str)] == [{"speed": 5}, 0.0, 2.0]


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


def test_in_the_end_jobs_under_way_are_waited_for(build: Build, make: Make) -> None:
    """Interpreter and process end next: a thread within a library's C++ would abort them."""
    plan = Plan()
    before = set(threading.enumerate())

    async def scenario() -> None:
        graph = build({"C": (Computes, {"numbers": "n"}, {})}, {"n": {"external": True}}, services={Plan: plan})
        async with Supervisor(graph.modules, graph.clock):
            await asyncio.sleep(0.1)
            graph.channels["n"].publish(make(1))
            await asyncio.sleep(0.1)
            assert "module C" in {thread.name for thread in set(threading.enumerate()) - before}
            threading.Timer(0.05, plan.release.set).start()
        assert "module C" not in {thread.name for thread in set(threading.enumerate()) - before}

    run_virtual(scenario(), patience_s=0.05)


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
async def test_a_constructor_that_fails_at_restart_does_not_end_the_supervision(build: Build, make: Make) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(0.5)
        bench.publish(make(-1))
        bench.plan.fail_construction = True
        await asyncio.sleep(2)
        assert bench.status == "failed"
        assert "ValueError: cannot be made" in bench.state.problem
        bench.plan.fail_construction = False
        await asyncio.sleep(5)
        assert bench.status == "running"


@in_virtual_time
async def test_an_observer_that_fails_is_logged_and_changes_nothing(
    build: Build, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(build)

    def broken(state: ModuleState) -> None:
        raise LookupError(state.name)

    end = bench.supervisor.observe(broken)
    async with bench.supervisor:
        await asyncio.sleep(1)
        assert bench.status == "running"
    assert "an observer of the states of modules failed and goes on" in caplog.text
    end()
    end()


@in_virtual_time
async def test_a_stop_that_fails_is_reported(build: Build, caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench(build)
    bench.plan.fail_stop = True
    async with bench.supervisor:
        await asyncio.sleep(1)
    assert bench.status == "stopped"
    assert "S failed while it was stopped: OSError: cannot let go" in caplog.text


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


@in_virtual_time
async def test_a_cancelled_module_counts_as_failed(build: Build) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(1)
        next(t for t in asyncio.all_tasks() if t.get_name() == "module S").cancel()
        await asyncio.sleep(0.1)
        assert (bench.status, bench.state.problem) == ("failed", "was cancelled")


@in_virtual_time
async def test_a_graph_can_be_started_again_after_it_was_stopped(build: Build, make: Make) -> None:
    bench = Bench(build)
    for _ in range(2):
        async with bench.supervisor:
            await asyncio.sleep(0.5)
            bench.publish(make(1))
            await asyncio.sleep(0.5)
            assert bench.status == "running"
    assert [what for _, what in bench.plan.events] == ["start", 1.0, "stop"] * 2


@in_virtual_time
async def test_a_recovery_is_said_once(build: Build, make: Make, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "hbba.supervisor")
    bench = Bench(build)
    async with bench.supervisor:
        await asyncio.sleep(0.5)
        bench.publish(make(-1))
        await asyncio.sleep(5)
    assert caplog.text.count("S runs again") == 1
    assert caplog.text.count("S failed") == 1


@in_virtual_time
async def test_modules_may_be_ended_and_started_afresh(build: Build, make: Make) -> None:
    bench = Bench(build)
    async with bench.supervisor:
        await bench.supervisor.started()
        bench.publish(make(-1))
        await asyncio.sleep(2)
        assert bench.state.restarts == 1
        first = bench.graph.modules["S"].module
        await bench.supervisor.stop_modules()
        assert {state.status for state in bench.supervisor.states.values()} == {"stopped"}
        bench.supervisor.start_modules()
        await bench.supervisor.started()
        assert (bench.status, bench.state.restarts, bench.state.problem) == ("running", 0, "")
        assert bench.graph.modules["S"].module is not first
        bench.publish(make(5))
        await asyncio.sleep(0.1)
    assert [what for _, what in bench.plan.events] == ["start", "stop", "start", "stop", "start", 5.0, "stop"]


@in_virtual_time
async def test_waiting_for_the_start_ends_with_a_failure_too(build: Build) -> None:
    bench = Bench(build)
    bench.plan.fail_start = True
    async with bench.supervisor:
        await asyncio.wait_for(bench.supervisor.started(), 1)
        assert bench.status == "failed"


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


@in_virtual_time
async def test_a_module_whose_first_start_failed_counts_as_started_though_it_is_restarted(build: Build) -> None:
    bench = Bench(build)
    bench.plan.fail_start = True
    async with bench.supervisor:
        await bench.supervisor.started()
        assert bench.clock.now() == 1_000_000
        assert bench.status == "failed"


class Importer(Module):
    """Computes with a package that it imports when it starts."""

    async def start(self) -> None:
        await self.compute(importlib.import_module, "half_imported")


async def test_a_module_whose_import_failed_runs_after_a_restart(
    build: Build, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stays of a failed import would make every further one fail, in another way."""
    package = tmp_path / "half_imported"
    package.mkdir()
    (package / "early.py").write_text("VALUE = 1\n")
    (package / "late.py").write_text("raise OSError(24, 'Too many open files')\n")
    (package / "__init__.py").write_text("import half_imported.early, half_imported.late\nhalf_imported.early.VALUE\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr("app.runtime.supervisor.FIRST_DELAY_S", 0.01)
    graph = build({"Importer": (Importer, {}, {})}, {})
    supervisor = Supervisor(graph.modules, RealClock())
    seen = asyncio.Queue[ModuleState]()
    supervisor.observe(seen.put_nowait)
    async with supervisor:
        while (state := await seen.get()).status != "failed":
            pass
        assert "Too many open files" in state.problem
        await asyncio.to_thread((package / "late.py").write_text, "VALUE = 'a file of another size'\n")
        # A start may have been on its way.
        while (state := await seen.get()).status == "starting" or "Too many open files" in state.problem:
            if state.status == "running":
                break
        assert state.status == "running", state.problem
