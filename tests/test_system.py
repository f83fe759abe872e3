"""The whole simulated robot, run for some seconds and judged by its own counters: rates, CPU, lateness, losses."""

from __future__ import annotations

import asyncio
from pathlib import Path
from statistics import median

import pytest

from app import paths
from app.attention.desires import Source
from app.config import load_configuration
from app.messages import Image, LinkStatus
from app.robots.simulated.gl import check_gl
from app.runtime.load import Load
from app.system import System
from tests.console.program import build

ME = Source("operator", "test")
RUN_S = 6.0
#: A busy computer may make the world slower, and with it every rate; pictures suffer first.
LEAST_SHARE = {"kinect": 0.25, "imv": 0.25}

needs_gl = pytest.mark.skipif(check_gl() is not None, reason=check_gl() or "")


@pytest.fixture
def lab() -> System:
    """The lab's program, built outside the event loop, since it reads its files."""
    return System(load_configuration(paths.config_dir() / "lab.yaml"))


@needs_gl
async def test_the_lab_keeps_its_rates_and_its_budgets(lab: System) -> None:
    """Everything desired at once: each channel at its rate, each module within its budget, nothing lost, loop awake."""
    lab.translator.set_capacity("cpu", 50.0, "everything at full rate")
    async with lab as system:
        system.workspace.add("Telepresence", intensity=8, utility=8, source=ME)
        system.workspace.add("FindQRCodes", intensity=8, utility=8, source=ME)
        await first(system, "qr_codes")
        await first(system, "point_cloud")
        before = {name: channel.statistics().published for name, channel in system.graph.channels.items()}
        loads: list[Load] = []
        worlds: list[float] = []
        while len(loads) < RUN_S:
            await system.clock.sleep(1.0)
            loads.append(system.load.latest)
            status = system.graph.channel("link_status").latest
            assert isinstance(status, LinkStatus)
            worlds.append(status.world_rate)
        world_rate = sum(worlds) / len(worlds)
        rates = {
            name: (channel.statistics().published - before[name]) / RUN_S
            for name, channel in system.graph.channels.items()
        }
        assert 0 < world_rate < 1.05
        for name, spec in system.graph.specs.items():
            if spec.rate_hz is not None and system.graph.channels[name].wanted:
                least = LEAST_SHARE.get(name, 0.6)
                # The world of a busy computer goes slower, and all that is sensed of it with it.
                assert least * spec.rate_hz * world_rate < rates[name] < 1.2 * spec.rate_hz, name
        for name in ("camera_jpeg", "point_cloud", "qr_codes"):
            assert rates[name] > 0.6 * rates["kinect"], name
        for name, slot in system.graph.modules.items():
            assert slot.spec.cpu_budget is not None
            assert median(load.modules[name] for load in loads) < slot.spec.cpu_budget, name
        assert [s.name for s in system.supervisor.states.values() if s.status != "running" or s.restarts] == []
        # Loading the kernels beside other programs has taken 1.3 s.
        assert system.watchdog.statistics().worst_lateness_s < 2.5


async def first(system: System, channel: str) -> None:
    """Wait for a message of ``channel``."""
    subscription = system.graph.channel(channel).subscribe("test")
    async with asyncio.timeout(20):
        await subscription.receive()
    system.graph.channel(channel).unsubscribe(subscription)


@needs_gl
async def test_what_nobody_desires_is_not_even_rendered(lab: System) -> None:
    """With no desire for images the camera rests; the first desire wakes it."""
    async with lab as system:
        await system.translator.settled()
        for desire in system.workspace.desires():
            if desire.cls in ("FindQRCodes", "LocateFaces"):
                system.workspace.remove(desire.id)
        await system.translator.settled()
        kinect = system.graph.channel("kinect")
        assert not kinect.wanted
        await first(system, "odometry")
        resting = kinect.statistics().published
        subscription = system.graph.channel("link_status").subscribe("test", capacity=30)
        for _ in range(20):
            await subscription.receive()
        # One picture may have been under way when the camera was told to rest.
        assert kinect.statistics().published <= resting + 1
        system.workspace.add("Telepresence", intensity=4, utility=1, source=ME)
        await first(system, "camera_jpeg")
        assert isinstance(kinect.latest, Image)


@needs_gl
async def test_a_lost_body_ends_the_program_with_a_reason(lab: System) -> None:
    """The link's process is killed: wait_failed says so."""
    import psutil

    async with lab as system:
        for child in psutil.Process().children():
            child.kill()
        async with asyncio.timeout(10):
            failure = await system.wait_failed()
    assert str(failure)


async def test_an_attention_that_dies_ends_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mistake in what runs beside the modules is not lived with."""
    system, _ = await asyncio.to_thread(build, tmp_path)

    async def broken() -> None:
        raise ZeroDivisionError("a mistake of ours")

    monkeypatch.setattr(system.translator, "run", broken)
    async with system:
        async with asyncio.timeout(5):
            failure = await system.wait_failed()
    assert isinstance(failure, ZeroDivisionError)
