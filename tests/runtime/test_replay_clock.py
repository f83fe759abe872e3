from __future__ import annotations

import asyncio

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.runtime.clock import in_virtual_time, run_virtual
from app.runtime.replay_clock import ReplayClock

BEGIN = 1_700_000_000.0


def clock_at(begin: float = BEGIN, end: float = BEGIN + 1000.0) -> ReplayClock:
    """A clock whose real time is the virtual loop's."""
    return ReplayClock(begin, end, real=asyncio.get_running_loop().time)


async def asleep(clock: ReplayClock, stamp: float, woken: list[tuple[float, float]]) -> None:
    await clock.sleep_until(stamp)
    woken.append((stamp, clock.now()))


@in_virtual_time
async def test_it_is_paused_until_it_runs_at_its_rate_and_paused_again() -> None:
    clock = clock_at()
    await asyncio.sleep(5)
    assert clock.now() == BEGIN
    clock.run(2.0)
    await asyncio.sleep(5)
    assert clock.now() == pytest.approx(BEGIN + 10, abs=1e-6)
    clock.run(0.1)
    await asyncio.sleep(5)
    assert clock.now() == pytest.approx(BEGIN + 10.5, abs=1e-6)
    clock.run(0)
    await asyncio.sleep(5)
    assert clock.now() == pytest.approx(BEGIN + 10.5, abs=1e-6)


@in_virtual_time
async def test_sleepers_wake_on_time_at_any_rate() -> None:
    clock, loop = clock_at(), asyncio.get_running_loop()
    clock.run(4.0)
    await clock.sleep(8.0)
    assert loop.time() == pytest.approx(2.0, abs=1e-3)
    assert clock.now() >= BEGIN + 8.0
    sleeping = asyncio.create_task(clock.sleep(8.0))
    await asyncio.sleep(1.0)
    clock.run(1.0)  # 4 s are left
    await sleeping
    assert loop.time() == pytest.approx(7.0, abs=1e-3)


@in_virtual_time
async def test_sleepers_of_a_paused_clock_wait_until_it_is_moved_and_wake_in_order() -> None:
    clock, woken = clock_at(), list[tuple[float, float]]()
    tasks = [asyncio.create_task(asleep(clock, BEGIN + s, woken)) for s in (3.0, 1.0, 2.0, 9.0)]
    await asyncio.sleep(60)
    assert woken == []
    assert clock.next_due == BEGIN + 1.0
    clock.advance_to(BEGIN + 3.0)
    await asyncio.sleep(0.01)
    assert woken == [(BEGIN + s, BEGIN + 3.0) for s in (1.0, 2.0, 3.0)]
    clock.advance_to(BEGIN + 1.0)
    assert clock.now() == BEGIN + 3.0, "it never goes back by this"
    clock.advance_to(BEGIN + 9.0)
    await asyncio.gather(*tasks)
    assert clock.next_due is None


@pytest.mark.parametrize("to", [BEGIN - 50.0, BEGIN + 50.0])
@in_virtual_time
async def test_a_jump_releases_everybody(to: float) -> None:
    clock, woken = clock_at(), list[tuple[float, float]]()
    clock.run(1.0)
    tasks = [asyncio.create_task(asleep(clock, BEGIN + s, woken)) for s in (300.0, 100.0)]
    await asyncio.sleep(1)
    clock.jump(to)
    await asyncio.gather(*tasks)
    assert [stamp for stamp, _ in woken] == [BEGIN + 100.0, BEGIN + 300.0]
    assert clock.now() == pytest.approx(to, abs=1e-3)
    await asyncio.sleep(2)
    assert clock.now() == pytest.approx(to + 2, abs=1e-3), "it goes on at the same rate"


@in_virtual_time
async def test_it_ends_with_the_recording() -> None:
    clock = clock_at(end=BEGIN + 2.0)
    clock.run(10.0)
    await asyncio.wait_for(clock.sleep_until(BEGIN + 2.0), 1)
    late = asyncio.create_task(clock.sleep_until(BEGIN + 2.5))
    await asyncio.sleep(5)
    assert clock.now() == BEGIN + 2.0
    clock.advance_to(BEGIN + 7.0)
    assert clock.now() == BEGIN + 2.0
    assert not late.done()
    clock.jump(BEGIN)
    await late


@in_virtual_time
async def test_no_time_and_time_gone_by_yield_once() -> None:
    clock = clock_at()
    order: list[str] = []

    async def other() -> None:
        order.append("other")

    task = asyncio.create_task(other())
    await clock.sleep(0)
    await clock.sleep(-1)
    await clock.sleep_until(BEGIN - 5)
    assert order == ["other"]
    await task


@in_virtual_time
async def test_who_gives_up_leaves_nothing_behind() -> None:
    clock = clock_at()
    keeper = asyncio.create_task(clock.sleep(500.0))
    for _ in range(10):
        given_up = [asyncio.create_task(clock.sleep(400.0)) for _ in range(100)]
        await asyncio.sleep(0)
        for task in given_up:
            task.cancel()
        await asyncio.wait(given_up)
    assert len(clock._sleepers) < 250
    assert clock.next_due == BEGIN + 500.0
    keeper.cancel()


def test_rates_that_cannot_be_are_refused() -> None:
    clock = ReplayClock(BEGIN)
    for rate in (-1.0, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="finite rate"):
            clock.run(rate)


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("run"), st.sampled_from([0.0, 0.1, 1.0, 20.0])),
        st.tuples(st.just("pass"), st.floats(0, 30)),
        st.tuples(st.just("advance"), st.floats(-10, 100)),
        st.tuples(st.just("jump"), st.floats(-200, 200)),
        st.tuples(st.just("sleep"), st.floats(-5, 120)),
        st.tuples(st.just("give up"), st.integers(0, 5)),
    ),
    max_size=30,
)


@given(STEPS)
@settings(deadline=None, max_examples=150)
@pytest.mark.slow
def test_whatever_is_done_with_it(steps: list[tuple[str, float]]) -> None:
    run_virtual(pass_through(steps))


async def pass_through(steps: list[tuple[str, float]]) -> None:
    clock = clock_at(end=BEGIN + 500.0)
    sleepers: list[tuple[float, int, asyncio.Task[None]]] = []
    woken: list[tuple[int, float, int, float]] = []
    epoch, last = 0, clock.now()

    async def sleeper(stamp: float, number: int, began_in: int) -> None:
        await clock.sleep_until(stamp)
        woken.append((began_in, stamp, number, clock.now()))
        if began_in == epoch:
            assert clock.now() >= stamp

    for step, value in steps:
        before = len(woken)
        if step == "run":
            clock.run(value)
        elif step == "pass":
            await asyncio.sleep(value)
        elif step == "advance":
            clock.advance_to(clock.now() + value)
        elif step == "jump":
            epoch += 1
            clock.jump(clock.now() + value)
            last = clock.now()
        elif step == "sleep":
            stamp, number = clock.now() + value, len(sleepers)
            sleepers.append((stamp, number, asyncio.create_task(sleeper(stamp, number, epoch))))
        elif waiting := [task for *_, task in sleepers if not task.done()]:
            waiting[int(value) % len(waiting)].cancel()
        for _ in range(4):
            await asyncio.sleep(0)
        now = clock.now()
        assert now >= last
        assert now <= BEGIN + 500.0
        last = now
        if step == "advance":  # all that woke did at once, in the order of their stamps
            assert woken[before:] == sorted(woken[before:], key=lambda w: w[1])
        # No sleeper is late by more than a timer's resolution, at the highest rate.
        for stamp, number, task in sleepers:
            assert task.done() or stamp > now - 20 * 1e-3, number
    for *_, task in sleepers:
        task.cancel()
    await asyncio.gather(*(task for *_, task in sleepers), return_exceptions=True)
