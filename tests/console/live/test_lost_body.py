"""The body's process is killed while the robot is driven: console and page stay, nothing moves by itself after."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Iterator
from pathlib import Path

import httpx
import psutil
import pytest

from tests.browser.running import Robot, running_robot
from tests.console.live.driving_robot import BEAT_S, drive_off, guard_goes_on, held, moving, still, until
from tests.console.live_client import page
from tests.patience import PATIENCE_S
from tests.robots.conftest import needs_gl

pytestmark = [pytest.mark.slow, needs_gl]


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """One to be killed."""
    with running_robot(tmp_path, calm=True, light=True) as running:
        yield running


def body(robot: Robot) -> psutil.Process | None:
    """The process with the wheels and the guard, while there is one."""
    with contextlib.suppress(psutil.NoSuchProcess):  # it may end while it is looked at
        for child in psutil.Process(robot.process.pid).children():
            if "app.robots.simulated.process" in child.cmdline():
                return child
    return None


async def said(rest: httpx.AsyncClient, reason: str) -> None:
    """Until the program's health and the robot's state have said ``reason``: asked often, for it ends soon."""
    left = {"health", "robot"}
    while left:
        if "health" in left and reason in (await rest.get("/health")).json()["problems"]:
            left.remove("health")
        if "robot" in left and (await rest.get("/robot")).json()["guard"]["reason"] == reason:
            left.remove("robot")
        await asyncio.sleep(BEAT_S)


async def all_at_work(rest: httpx.AsyncClient) -> None:
    """Until every module is: a busy computer lets one hang for a while, and it is started again."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            modules = (await rest.get("/modules")).json()["modules"]
            if all(module["state"] in ("running", "starting") for module in modules):
                return
            await asyncio.sleep(BEAT_S)


async def test_a_killed_body_is_replaced_and_drives_when_pressed_again(robot: Robot) -> None:
    async with page(robot.url) as ann, httpx.AsyncClient(base_url=f"{robot.url}/api/v1", timeout=PATIENCE_S) as rest:
        goal = {"class": "GoTo", "intensity": 1, "utility": 1, "params": {"x": 1, "y": 0}}
        async with held(ann):
            await drive_off(robot, ann)
            await rest.post("/desires", json=goal)
            first = body(robot)
            assert first is not None
            helpers = first.children(recursive=True)
            died = "the simulated robot's process was killed by signal 9"
            reason = f"The body does not answer: {died}. It is started again."
            heard = asyncio.create_task(said(rest, reason))
            first.kill()
            lost = await ann.until("status", lambda s: s["guard"]["reason"] == reason, PATIENCE_S)
            assert lost["guard"]["state"] == "silent"
            assert lost["guard"]["applied"] == {"linear_mps": 0, "angular_radps": 0, "lateral_mps": 0}
            await asyncio.wait_for(heard, PATIENCE_S)
            # The key stays down all the while.
            back = await ann.until("status", lambda s: s["guard"]["state"] == "idle", PATIENCE_S)
            assert back["stamp"] > lost["stamp"]
            rows = await guard_goes_on(robot, 1.0)
            assert not any(map(moving, rows)), "a log of the new guard's own"
        # What computed its sound has gone with it.
        assert (await asyncio.to_thread(psutil.wait_procs, helpers, PATIENCE_S))[1] == []
        second = body(robot)
        assert second is not None
        assert second.pid != first.pid
        await ann.until("status", lambda s: s["odometry"] and abs(s["odometry"]["theta"]) < 0.05, PATIENCE_S)
        classes = {desire["class"] for desire in (await rest.get("/desires")).json()["desires"]}
        assert "GoTo" not in classes, "it does not set out for what was wanted before"
        assert "Telepresence" in classes
        async with held(ann):
            await drive_off(robot, ann)
        await ann.drive(0.0, held=False)
        await until(robot, still)
        await all_at_work(rest)
