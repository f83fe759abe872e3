"""The closed loop in a running program: what is measured reaches attention, REST's records and the timeline."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest

from app.attention.closed_loop import Adjustment
from app.attention.desires import Source
from app.messages import Confidence, LoadReport
from app.program.config import ClosedLoopConfig, load_configuration
from app.program.system import System
from tests.console.program import Body, write_program
from tests.patience import PATIENCE_S

ME = Source("operator", "test")


def system(folder: Path, loop: ClosedLoopConfig | None) -> System:
    configuration = load_configuration(write_program(folder))
    attention = configuration.program.attention.model_copy(update={"closed_loop": loop})
    program = configuration.program.model_copy(update={"attention": attention})
    return System(replace(configuration, program=program), link=Body())


@pytest.fixture
def closed(tmp_path: Path) -> System:
    return system(tmp_path, ClosedLoopConfig())


@pytest.fixture
def opened(tmp_path: Path) -> System:
    return system(tmp_path, None)


async def test_without_the_loop_nothing_follows_what_is_measured(opened: System) -> None:
    assert opened.control is None
    async with opened:
        load = opened.graph.channels["load"].subscribe("test")
        async with asyncio.timeout(PATIENCE_S):
            report: LoadReport = await load.receive()
        assert report.loop is None


async def test_what_is_measured_is_published_and_what_follows_is_put_in_force(closed: System) -> None:
    control, translator = closed.control, closed.translator
    assert control is not None
    dear = next(s for s in closed.table.strategies if s.costs.get("cpu") and s.filters)
    module = next(iter(dear.filters)).partition(".")[0]
    async with closed:
        closed.workspace.add(dear.cls, intensity=8, utility=1, source=ME)
        load = closed.graph.channels["load"].subscribe("test")
        async with asyncio.timeout(PATIENCE_S):
            while (report := await load.receive()).loop is None or not report.loop.strategies:
                pass
        (first, *_) = report.loop.strategies
        assert first.declared == closed.table[first.name].costs["cpu"]
        assert (report.loop.budget, report.loop.share) == (translator.budgets["cpu"], control.report().share)

        cost = 2 * dear.costs["cpu"]
        control.apply(Adjustment({dear.name: cost}, None, "it takes more"))
        await translator.settled()
        assert translator.table[dear.name].costs["cpu"] == cost
        assert translator.table[dear.name].costs.keys() == dear.costs.keys(), "other resources stay"
        assert closed.table[dear.name] is dear, "what was declared stays"
        control.apply(Adjustment({}, 0.5, "others press"))
        assert translator.capacities["cpu"] == pytest.approx(0.5 * translator.budgets["cpu"])

        for _ in range(2):
            control.hear(module, Confidence(closed.clock.now(), 0.5, "it is dark"))
        assert translator.table[dear.name].utility == dear.utility, "it does not last yet"
        closed.timeline.clear()
        control.trust({module: (0.5, "it is dark")})
        assert translator.table[dear.name].utility == dear.utility / 2
        assert [event.text for event in closed.timeline.query(kinds={"capacity"})] == [
            f"{module} counts for 50 % of its utility: it is dark"
        ]
        control.reset()
        assert translator.table[dear.name].utility == dear.utility
