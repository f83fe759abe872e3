from __future__ import annotations

import asyncio

import pytest

from app.runtime.clock import in_virtual_time
from app.runtime.pending_work import PendingWork


@in_virtual_time
async def test_who_waits_goes_on_when_the_last_has_ended() -> None:
    activity = PendingWork()
    await activity.ended()

    async def work(seconds: float) -> None:
        with activity.one():
            await asyncio.sleep(seconds)

    tasks = [asyncio.create_task(work(s)) for s in (1.0, 3.0, 2.0)]
    await asyncio.sleep(0)
    assert activity.under_way == 3
    began = asyncio.get_running_loop().time()
    await activity.ended()
    assert asyncio.get_running_loop().time() - began == pytest.approx(3.0)
    await asyncio.gather(*tasks)


@in_virtual_time
async def test_work_that_fails_has_ended_too() -> None:
    activity = PendingWork()
    with pytest.raises(ZeroDivisionError), activity.one():
        raise ZeroDivisionError
    assert activity.under_way == 0


async def test_it_is_quiet_once_every_chain_of_tasks_waits() -> None:
    activity, done = PendingWork(), asyncio.Event()

    async def chain(links: int) -> None:
        await asyncio.sleep(0)
        if links:
            await asyncio.create_task(chain(links - 1))
        else:
            done.set()

    task = asyncio.create_task(chain(20))
    await activity.quiet()
    assert done.is_set()
    await task


async def test_it_is_quiet_once_threads_have_come_back_and_been_heard() -> None:
    activity, heard = PendingWork(), list[str]()

    async def compute(word: str) -> None:
        with activity.one():
            heard.append(await asyncio.to_thread(lambda: word))

    async def work() -> None:
        await compute("first")
        await compute("second")

    task = asyncio.create_task(work())
    await activity.quiet()
    assert heard == ["first", "second"]
    await task


async def test_a_task_that_never_waits_does_not_hold_it_up_for_ever() -> None:
    async def spin() -> None:
        while True:  # noqa: ASYNC110  # that it never waits is the point
            await asyncio.sleep(0)

    spinning = asyncio.create_task(spin())
    await PendingWork().quiet()
    assert not spinning.done(), "it spins on, and was not waited for"
    spinning.cancel()


async def test_the_loop_still_says_what_it_has_left_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    # asyncio's loops have the attribute; without it, `quiet` would take all its turns each time.
    most = 10_000
    turns = iter(range(most))
    monkeypatch.setattr("app.runtime.pending_work.LONGEST_SPIN", most)
    monkeypatch.setattr("app.runtime.pending_work.range", lambda _: turns, raising=False)
    await PendingWork().quiet()
    assert len(list(turns)) > most - 100
