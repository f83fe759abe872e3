"""The whole simulated robot, run for some seconds and judged by its own counters: rates, CPU, losses."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import pytest

from app.attention.desires import Source
from app.base import paths
from app.messages import Image
from app.program.config import load_configuration
from app.program.system import System
from app.robots.simulated.gl import check_gl
from app.runtime.load import CpuLoad
from app.runtime.supervisor import ModuleState
from tests.console.program import build
from tests.patience import PATIENCE_S

ME = Source("operator", "test")
RUN_S = 6.0
#: Of the rate by the world's own time: a busy computer loses pictures and sound first.
LEAST_SHARE = {"kinect": 0.1, "panorama": 0.1, "microphones": 0.1}

needs_gl = pytest.mark.skipif(check_gl() is not None, reason=check_gl() or "")


@pytest.fixture
def lab() -> System:
    """The lab's program, built outside the event loop, since it reads its files; with a budget that is not this
    computer's."""
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    attention = configuration.program.attention.model_copy(update={"closed_loop": None})
    return System(replace(configuration, program=configuration.program.model_copy(update={"attention": attention})))


@needs_gl
async def test_the_lab_keeps_its_rates_and_its_budgets(lab: System) -> None:
    """Everything desired at once: each channel at its rate, each module within its budget, none fails."""
    lab.translator.set_capacity("cpu", 50.0, "everything at full rate")
    failed: list[ModuleState] = []
    # A module that a busy computer keeps waiting may count as hung, and is restarted: that is not its fault.
    lab.supervisor.observe(lambda state: failed.append(state) if state.status == "failed" else None)
    async with lab as system:
        system.workspace.add("Telepresence", intensity=8, utility=8, source=ME)
        system.workspace.add("FindQRCodes", intensity=8, utility=8, source=ME)
        await first(system, "qr_codes")
        await first(system, "point_cloud")
        # A busy computer takes time from the program now and then: some window of time is kept, however late it comes.
        async with asyncio.timeout(PATIENCE_S):
            while wrong := (window := await measured(system)).wrong(system):
                print(f"not in this window: {wrong}")
        rates, loads = window.rates, window.loads
        for name in ("camera_jpeg", "point_cloud", "qr_codes"):
            assert rates[name] > 0, name
        for name, slot in system.graph.modules.items():
            assert slot.spec.cpu_budget is not None
            assert median(load.modules[name] for load in loads) < slot.spec.cpu_budget, name
        assert failed == []


@dataclass(frozen=True)
class Window:
    """What RUN_S seconds of the program showed: rates of channels by the world's time and by this computer's."""

    rates: dict[str, float]
    rates_here: dict[str, float]
    loads: list[CpuLoad]

    def wrong(self, system: System) -> list[str]:
        """The wanted channels that are not at their rate."""
        return [
            name
            for name, spec in system.graph.specs.items()
            if spec.rate_hz is not None
            and system.graph.channels[name].wanted
            and not (
                LEAST_SHARE.get(name, 0.6) * spec.rate_hz < self.rates[name]
                and self.rates_here[name] < 1.2 * spec.rate_hz + 1
            )
        ]


async def measured(system: System) -> Window:
    """The next window."""
    before = {name: channel.periods for name, channel in system.graph.channels.items()}
    began = system.clock.now()
    loads: list[CpuLoad] = []
    while len(loads) < RUN_S:
        await system.clock.sleep(1.0)
        loads.append(system.load.latest)
    counts = {name: channel.periods - before[name] for name, channel in system.graph.channels.items()}
    passed_s = system.clock.now() - began
    # The world of a busy computer goes slower. Odometry, a matter of physics alone, says how much time went by.
    odometry_hz = system.graph.specs["odometry"].rate_hz
    assert odometry_hz is not None
    world_s = max(counts["odometry"], 1) / odometry_hz
    return Window(
        {name: count / world_s for name, count in counts.items()},
        {name: count / passed_s for name, count in counts.items()},
        loads,
    )


async def first(system: System, channel: str) -> None:
    """Wait for a message of ``channel``."""
    subscription = system.graph.channel(channel).subscribe("test")
    async with asyncio.timeout(PATIENCE_S):
        await subscription.receive()
    system.graph.channel(channel).unsubscribe(subscription)


@needs_gl
async def test_without_a_desire_nothing_is_rendered(lab: System) -> None:
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
        # One picture may have been under way when the camera was stopped.
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
        async with asyncio.timeout(PATIENCE_S):
            failure = await system.wait_failed()
    assert str(failure)


async def test_an_attention_that_dies_ends_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bug in a task beside the modules ends the program."""
    system, _ = await asyncio.to_thread(build, tmp_path)

    async def broken() -> None:
        raise ZeroDivisionError("a mistake of ours")

    monkeypatch.setattr(system.translator, "run", broken)
    async with system:
        async with asyncio.timeout(PATIENCE_S):
            failure = await system.wait_failed()
    assert isinstance(failure, ZeroDivisionError)
