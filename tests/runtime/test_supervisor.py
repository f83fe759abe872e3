"""Modules are started, restarted and stopped; one that fails disturbs no other."""

from __future__ import annotations

import asyncio
import importlib
import itertools
import logging
import threading
from pathlib import Path

import pytest

from app.runtime.clock import RealClock, in_virtual_time, run_virtual
from app.runtime.filter import CLOSED
from app.runtime.module import Module
from app.runtime.supervisor import ModuleState, Supervisor
from tests.runtime.supervised import Bench, Build, Computes, Make, Plan


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
    assert "ZeroDivisionError: a bad message (supervised.py:" in bench.state.problem


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
