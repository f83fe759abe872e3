"""The program's own records, channel by channel."""

from __future__ import annotations

import asyncio
import logging
import math
from pathlib import Path
from typing import Any

import pytest

from app.attention.desires import Source
from app.messages import Desires, Divisors, IntentionReport, LoadReport, LogLine, ModuleRecord, TimelineEvent
from app.program.config import load_configuration
from app.program.self_report import SelfReport
from app.program.system import System
from app.runtime.subscription import Subscription
from tests.console.program import Body, build
from tests.patience import PATIENCE_S

CHANNELS = """\
divisors: {type: Divisors, external: true}
module_states: {type: ModuleRecord, external: true}
log: {type: LogLine, external: true}
"""
OPERATOR = Source("operator", "a person")


@pytest.fixture
def system(tmp_path: Path) -> System:
    build(tmp_path)
    table = tmp_path / "channels.yaml"
    table.write_text(table.read_text(encoding="utf-8") + CHANNELS, encoding="utf-8")
    return System(load_configuration(tmp_path / "program.yaml"), link=Body())


def listen(system: System, channel: str) -> Subscription[Any]:
    return system.graph.channel(channel).subscribe("test", capacity=100)


async def until(subscription: Subscription[Any], wanted: Any) -> Any:
    """The first message that ``wanted`` says yes to."""
    async with asyncio.timeout(PATIENCE_S):
        while not wanted(message := await subscription.receive()):
            pass
        return message


async def test_a_desire_is_published_with_the_intention_and_the_divisors_that_follow(system: System) -> None:
    desires, intentions, divisors, events = (
        listen(system, n) for n in ("workspace", "intention", "divisors", "events")
    )
    async with system:
        system.workspace.add("Telepresence", intensity=4, utility=1, params={"max_points": 2000}, source=OPERATOR)
        record = await until(desires, lambda m: m.desires)
        assert isinstance(record, Desires)
        (desire,) = record.desires
        assert (desire.cls, desire.source, desire.expires) == ("Telepresence", OPERATOR, None)
        assert desire.params["max_points"] == 2000
        intention = await until(intentions, lambda m: "picture-fast" in [s.name for s in m.strategies])
        assert isinstance(intention, IntentionReport)
        assert {name: use.used for name, use in intention.use.items()} == {"cpu": 40.0}
        assert {cls: reason.state for cls, reason in intention.reasons.items()} == {"Telepresence": "fulfilled"}
        moved = await until(divisors, lambda m: sum(map(math.isfinite, m.divisors)) == 2)
        assert isinstance(moved, Divisors)
        now = dict(zip(moved.filters, moved.divisors, strict=True))
        opened = {"CameraStream.images": 1, "PointCloudBuilder.images": 3}
        assert now == {"AudioStream.audio": math.inf, "Teleop.twist": math.inf, **opened}
        event = await until(events, lambda m: m.kind == "intention")
        assert isinstance(event, TimelineEvent)
        assert event.data["on"] == ["picture-fast"]


async def test_modules_load_and_log_lines_are_published(system: System) -> None:
    modules, loads, lines = (listen(system, n) for n in ("module_states", "load", "log"))
    async with system:
        running = await until(modules, lambda m: m.module == "Teleop" and m.status == "running")
        assert isinstance(running, ModuleRecord)
        await asyncio.to_thread(logging.getLogger("hbba.Teleop").warning, "heard in a %s", "thread")
        line = await until(lines, lambda m: m.source == "hbba.Teleop")
        assert line == LogLine(line.stamp, logging.WARNING, "hbba.Teleop", "heard in a thread")
        load = await until(loads, lambda m: True)
        assert isinstance(load, LoadReport)
        assert [module.name for module in load.modules] == list(system.graph.modules)


async def test_after_its_end_nothing_is_published_and_no_logger_refers_to_it(system: System) -> None:
    before = list(logging.getLogger().handlers)
    async with system:
        assert len(logging.getLogger().handlers) == len(before) + 1
    assert logging.getLogger().handlers == before


def test_channels_that_are_not_there_are_not_missed() -> None:
    SelfReport({}, lambda: 0.0, dict).load(LoadReport(1.0, 1.0, 3.0, None, ()))
