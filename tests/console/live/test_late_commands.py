"""The whole program over a slow network, and frozen: commands that come late never move the wheels.

The guard's own log is the witness. Nothing here is about how long something takes: a busy computer makes commands only
older.
"""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Iterator

import pytest

from tests.browser.running import Robot, running_robot
from tests.console.live.driving_robot import (
    all_arrived,
    drive_off,
    guard_goes_on,
    held,
    moving,
    still,
    until,
)
from tests.console.live_client import page
from tests.console.slow_link import slow_link
from tests.patience import PATIENCE_S
from tests.robots.conftest import needs_gl

pytestmark = [pytest.mark.slow, needs_gl]

VALIDITY_S = 0.4
#: Longer than any limit of driving: the age of a command, of what a page sees, and of a page that counts as lost.
LATE_S = 1.5


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One for the whole file."""
    with running_robot(tmp_path_factory.mktemp("robot"), calm=True, light=True) as running:
        yield running


async def test_on_a_quick_link_it_drives_and_stops(robot: Robot) -> None:
    async with slow_link(robot.url) as link, page(link.url) as ann:
        async with held(ann):
            await drive_off(robot, ann)
        await ann.drive(0.0, held=False)
        await until(robot, still)


@pytest.mark.parametrize(("up_s", "down_s"), [(0.5, 0.0), (LATE_S, 0.0), (0.0, LATE_S), (LATE_S, LATE_S)])
async def test_over_a_slow_link_it_never_moves_and_says_so(robot: Robot, up_s: float, down_s: float) -> None:
    before = len(await until(robot, still))
    async with slow_link(robot.url) as link, page(robot.url, "Eve") as eve:
        link.up_s, link.down_s = up_s, down_s
        async with page(link.url) as ann:
            async with held(ann):
                notice = await ann.until("notice", within_s=PATIENCE_S)
                status = await ann.until("status", lambda s: s["waits"] != "", within_s=PATIENCE_S)
            for text in (notice["text"], status["waits"]):
                assert text.endswith(": driving waits.")
            # The release, too, is heard however late.
            await ann.drive(0.0, held=False)
            await all_arrived(ann)
            assert (await eve.until("status"))["waits"] == "", "only the page that is late waits"
            pages = {p["operator"]: p for p in (await asyncio.to_thread(robot.get, "/viewers"))["pages"]}
            assert pages["Ann"]["waits"].endswith(": driving waits.")
            assert pages["Ann"]["late_ms"] > 1e3 * max(up_s, down_s)
            assert pages["Eve"]["waits"] == ""
    rows = await asyncio.to_thread(robot.wheels)
    assert not any(map(moving, rows[before:]))


async def test_a_delay_that_begins_while_driving_stops_for_good(robot: Robot) -> None:
    async with slow_link(robot.url) as link, page(link.url) as ann:
        async with held(ann):
            await drive_off(robot, ann)
            link.up_s = LATE_S
            stopped = len(await until(robot, still))
            sent = ann.sequence
            # Held all the while, and let go only when the first late ones have come.
            await ann.until("notice", lambda n: n["text"].endswith(": driving waits."), within_s=PATIENCE_S)
        await ann.drive(0.0, held=False)
        assert ann.sequence - sent > 10
        await all_arrived(ann)
        rows = await until(robot, still)
        assert not any(map(moving, rows[stopped:]))
        # The network is well again: what is pressed again drives.
        link.up_s = 0.0
        await all_arrived(ann)
        await ann.until("status", lambda s: s["waits"] == "", within_s=PATIENCE_S)
        async with held(ann):
            await drive_off(robot, ann)
        await ann.drive(0.0, held=False)
        await until(robot, still)


async def test_what_piled_up_before_a_frozen_program_moves_nothing_when_it_thaws(robot: Robot) -> None:
    async with page(robot.url) as ann:
        async with held(ann):
            await drive_off(robot, ann)
            robot.process.send_signal(signal.SIGSTOP)
            try:
                sent = ann.sequence
                stopped = len(await until(robot, still))
                # The guard's log, which goes on, is the clock.
                await until(robot, lambda _: ann.sequence >= sent + 10)
            except BaseException:
                robot.process.send_signal(signal.SIGCONT)
                raise
        # What waits in the socket is too old by then.
        await guard_goes_on(robot, VALIDITY_S)
        robot.process.send_signal(signal.SIGCONT)
        await all_arrived(ann)
        rows = await guard_goes_on(robot, 1.0)
        assert not any(map(moving, rows[stopped:]))


async def test_the_emergency_stop_is_obeyed_late_and_its_release_is_not(robot: Robot) -> None:
    async with slow_link(robot.url) as link, page(robot.url, "Eve") as eve, page(link.url) as ann:
        await ann.greeted()
        await eve.greeted()
        link.up_s = LATE_S
        await ann.send("e_stop")
        await ann.send("clear_e_stop")
        await ann.until("notice", lambda n: n["text"].endswith("the emergency stop stays latched."), PATIENCE_S)
        await eve.until("status", lambda s: s["guard"]["e_stopped"], PATIENCE_S)
        latched = await eve.until("status")
        await eve.send("clear_e_stop", heard=latched["stamp"] - 60)
        await eve.until("notice", lambda n: "emergency stop" in n["text"])
        assert (await eve.until("status"))["guard"]["e_stopped"]
        await eve.send("clear_e_stop")
        await eve.until("status", lambda s: not s["guard"]["e_stopped"], PATIENCE_S)
