from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.runtime.clock import RealClock, VirtualClock, in_virtual_time, run_virtual


def test_an_hour_passes_in_no_time() -> None:
    async def hour() -> float:
        clock = VirtualClock()
        began = clock.now()
        await asyncio.gather(*(clock.sleep(seconds) for seconds in (3600, 10, 1800)))
        return clock.now() - began

    # In real time the test would run into its own limit.
    assert run_virtual(hour()) == pytest.approx(3600)


@in_virtual_time
async def test_timers_go_off_in_order_and_at_their_time() -> None:
    clock = VirtualClock()
    went_off: list[tuple[str, float]] = []

    async def wait(name: str, seconds: float) -> None:
        await clock.sleep(seconds)
        went_off.append((name, round(clock.now() - clock.origin, 6)))

    await asyncio.gather(wait("c", 3), wait("a", 1), wait("b", 2.5))
    assert went_off == [("a", 1), ("b", 2.5), ("c", 3)]


def test_time_does_not_pass_while_a_thread_works() -> None:
    async def scenario() -> list[str]:
        order: list[str] = []
        asyncio.get_running_loop().call_later(1000, order.append, "timer")
        gate = threading.Event()
        threading.Timer(0.05, gate.set).start()
        await asyncio.to_thread(gate.wait)
        order.append("thread")
        await asyncio.sleep(2000)
        return order

    assert run_virtual(scenario()) == ["thread", "timer"]


def test_a_thread_that_never_comes_back_holds_time_up_only_for_so_long() -> None:
    gate = threading.Event()

    async def scenario() -> float:
        clock = VirtualClock()
        task = asyncio.create_task(asyncio.to_thread(gate.wait))
        await asyncio.sleep(3600)
        gate.set()
        await task
        return clock.now() - clock.origin

    assert run_virtual(scenario(), patience_s=0.02) == pytest.approx(3600)


def test_a_task_that_spins_keeps_no_result_out() -> None:
    async def scenario() -> int:
        turns = 0
        task = asyncio.create_task(asyncio.to_thread(int))
        while not task.done():
            turns += 1
            await asyncio.sleep(0)
        return turns

    assert run_virtual(scenario()) == run_virtual(scenario()) > 0


def test_two_runs_are_the_same() -> None:
    async def scenario() -> list[tuple[str, float]]:
        clock = VirtualClock()
        log: list[tuple[str, float]] = []

        async def worker(name: str, period_s: float) -> None:
            for _ in range(20):
                await clock.sleep(period_s)
                await asyncio.to_thread(sum, range(1000))
                log.append((name, clock.now()))

        await asyncio.gather(worker("a", 0.3), worker("b", 0.7), worker("c", 0.45))
        return log

    assert run_virtual(scenario()) == run_virtual(scenario())


@given(st.floats(0, 1e5), st.lists(st.floats(0, 1e3), max_size=8))
def test_sleep_until_never_wakes_early(origin: float, delays: list[float]) -> None:
    async def scenario() -> None:
        clock = VirtualClock(1_800_000_000.0 + origin)
        for delay in delays:
            stamp = clock.now() + delay
            await clock.sleep_until(stamp)
            assert stamp <= clock.now() < stamp + 1e-3

    run_virtual(scenario())


@pytest.mark.parametrize("make", [VirtualClock, RealClock])
def test_a_sleep_of_no_time_lets_the_others_run(make: Callable[[], VirtualClock | RealClock]) -> None:
    async def scenario() -> list[int]:
        clock = make()
        order: list[int] = []

        async def other() -> None:
            order.append(1)

        task = asyncio.create_task(other())
        await clock.sleep(-1)
        order.append(2)
        await clock.sleep_until(clock.now() - 5)
        await task
        return order

    assert run_virtual(scenario()) == [1, 2]


def test_outside_a_loop_the_virtual_clock_keeps_its_last_reading() -> None:
    clock = VirtualClock(50.0)
    assert clock.now() == 50.0

    async def scenario() -> float:
        await clock.sleep(7)
        return clock.now()

    assert run_virtual(scenario()) == clock.now() == 57.0


def test_the_real_clock_reads_unix_time_and_never_goes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = RealClock()
    assert clock.now() == pytest.approx(time.time(), abs=1.0)
    before = clock.now()
    # The computer's clock is set back by a day.
    real_time = time.time
    monkeypatch.setattr(time, "time", lambda: real_time() - 86_400)
    assert clock.now() >= before
    other_process = time.monotonic() + clock.offset
    assert other_process == pytest.approx(clock.now(), abs=1.0)


async def test_the_real_clock_sleeps_at_least_as_long_as_asked() -> None:
    clock = RealClock()
    stamp = clock.now() + 0.01
    await clock.sleep_until(stamp)
    assert clock.now() >= stamp


def test_errors_come_out_of_a_virtual_run() -> None:
    async def fails() -> None:
        raise LookupError("out")

    with pytest.raises(LookupError, match="out"):
        run_virtual(fails())
