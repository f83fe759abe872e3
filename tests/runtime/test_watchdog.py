from __future__ import annotations

import asyncio
import re
import sys
import threading
import time
from pathlib import Path

import pytest

from app.runtime.load import CpuMeter, MeteredCoroutine
from app.runtime.watchdog import PROJECT_ROOTS, Blockage, LoopWatchdog

HERE = Path(__file__).resolve().parent


def block(seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        pass


async def blocking_step(seconds: float) -> None:
    block(seconds)


async def test_a_module_that_blocks_the_loop_is_named_once_and_its_recovery_too() -> None:
    meters = {"Idle": CpuMeter(), "Busy": CpuMeter()}
    reports: list[Blockage] = []
    both = asyncio.Event()
    loop = asyncio.get_running_loop()

    def report(blockage: Blockage) -> None:
        # On a busy computer the loop may be late without a fault of any module: those reports name none.
        if blockage.module:
            reports.append(blockage)
        if len(reports) == 2:
            loop.call_soon_threadsafe(both.set)

    async with LoopWatchdog(meters, report, limit_s=0.1, period_s=0.02) as watchdog:
        await asyncio.sleep(0)
        await asyncio.create_task(MeteredCoroutine(blocking_step(0.5), meters["Busy"]))
        await both.wait()
        statistics = watchdog.statistics()
    first, second = reports
    assert (first.module, first.over) == ("Busy", False)
    assert (second.module, second.over) == ("Busy", True)
    assert 0.1 < first.lasted_s < second.lasted_s
    assert re.search(r"test_watchdog\.py:\d+ in block$", first.blocking)
    assert statistics.blockages >= 1
    assert statistics.worst_lateness_s >= second.lasted_s > 0.3


async def test_the_innermost_frame_of_the_project_is_blamed() -> None:
    # The machinery that runs every module is the project's too, but it is not to blame for what it runs.
    caught: asyncio.Future[Blockage] = asyncio.get_running_loop().create_future()
    loop = asyncio.get_running_loop()

    def report(blockage: Blockage) -> None:
        if not blockage.over and not caught.done():
            loop.call_soon_threadsafe(caught.set_result, blockage)

    async with LoopWatchdog({}, report, limit_s=0.1, period_s=0.02):
        await asyncio.sleep(0)
        await asyncio.create_task(MeteredCoroutine(blocking_step(0.5), CpuMeter()))
        blockage = await caught
    assert blockage.module == ""
    assert "app/runtime/load.py" in blockage.where
    assert "something outside any module blocks the event loop at" in str(blockage)


async def step_in_the_machinery() -> None:
    CpuMeter().step(time.sleep, 0.5)


@pytest.mark.blocking("that is what is watched for")
async def test_the_machinery_is_not_blamed_for_whom_it_works() -> None:
    loop = asyncio.get_running_loop()
    caught: asyncio.Future[Blockage] = loop.create_future()

    def report(blockage: Blockage) -> None:
        if not blockage.over and not caught.done():
            loop.call_soon_threadsafe(caught.set_result, blockage)

    async with LoopWatchdog({}, report, limit_s=0.1, period_s=0.02, roots=(*PROJECT_ROOTS, HERE)):
        await asyncio.sleep(0)
        await step_in_the_machinery()
        blockage = await caught
    assert re.search(r"test_watchdog\.py:\d+ in step_in_the_machinery$", blockage.where)
    assert "load.py" in blockage.blocking


async def test_a_loop_that_comes_round_is_left_alone() -> None:
    reports: list[Blockage] = []
    async with LoopWatchdog({}, reports.append, limit_s=5.0, period_s=0.001) as watchdog:
        while watchdog.statistics().beats < 5:  # noqa: ASYNC110  # the real clock is what is watched here
            await asyncio.sleep(0)
    assert reports == []
    assert watchdog.statistics().blockages == 0


def test_a_loop_that_waits_for_its_turn_is_no_fault() -> None:
    # The stack of a loop that sleeps in select, as a starved one looks.
    loop = asyncio.new_event_loop()
    seen: list[Blockage | None] = []
    looked = threading.Event()
    watchdog = LoopWatchdog({})

    def look(thread: int) -> None:
        watchdog._loop_thread = thread
        while True:
            frame = sys._current_frames()[thread]
            if frame.f_code.co_name == "select":
                break
        seen.append(watchdog._look(1.0))
        looked.set()
        loop.call_soon_threadsafe(loop.stop)

    threading.Thread(target=look, args=(threading.get_ident(),), daemon=True).start()
    loop.run_forever()
    loop.close()
    assert looked.is_set()
    assert seen == [None]


async def test_a_blockage_that_was_not_sampled_is_reported_when_it_is_over() -> None:
    reports: list[Blockage] = []
    reported = asyncio.Event()
    loop = asyncio.get_running_loop()

    def report(blockage: Blockage) -> None:
        reports.append(blockage)
        loop.call_soon_threadsafe(reported.set)

    async with LoopWatchdog({}, report, limit_s=5.0, period_s=0.01) as watchdog:
        watchdog._late.append(6.0)
        await reported.wait()
    assert reports == [Blockage("", "", "", 6.0, True)]


@pytest.mark.parametrize(
    ("blockage", "said"),
    [
        (
            Blockage("Faces", "app/modules/faces.py:12 in find", "numpy/core.py:5 in dot", 0.31, False),
            "Faces blocks the event loop at app/modules/faces.py:12 in find (in numpy/core.py:5 in dot) for 0.31 s",
        ),
        (
            Blockage("Faces", "app/a.py:1 in f", "app/a.py:1 in f", 2, True),
            "Faces blocked the event loop at app/a.py:1 in f for 2.00 s",
        ),
        (
            Blockage("", "", "", 4.35, True),
            (
                "the event loop was blocked for 4.35 s, not by Python code: "
                "the computer had no time for this program, or a call held the interpreter lock"
            ),
        ),
    ],
)
def test_a_blockage_is_said_in_one_sentence(blockage: Blockage, said: str) -> None:
    assert str(blockage) == said
