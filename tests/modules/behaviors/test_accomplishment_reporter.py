"""A behavior's reports of accomplishment: each once, of the desires that they are about."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, cast

from pydantic import BaseModel

from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.messages import Accomplishment
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.runtime.clock import VirtualClock, in_virtual_time
from app.runtime.module import Module, ModuleContext
from tests.modules.fakes import Bench, drain


class Parameters(BaseModel):
    x: float = 0.0


CLASSES = DesireClasses([DesireClass("Wave", "Wave", "", Parameters), DesireClass("Nod", "Nod", "")])


class Waver(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.accomplishments = AccomplishmentReporter(self, "Wave")


class Scene:
    def __init__(self, *, wired: bool = True) -> None:
        self.workspace = IntentionWorkspace(CLASSES, VirtualClock().now)
        self.bench = Bench(
            f"{__name__}:Waver",
            outputs={"accomplishments": Accomplishment} if wired else {},
            services={IntentionWorkspace: self.workspace} if wired else {},
        )

    def desire(self, cls: str = "Wave", params: Mapping[str, Any] | None = None, utility: float = 4) -> str:
        source = Source("rest", "test")
        return self.workspace.add(cls, intensity=4, utility=utility, params=params, source=source).id

    @property
    def waver(self) -> Waver:
        return cast(Waver, self.bench.slot.module)


def at(x: float) -> Callable[[Any], bool]:
    return lambda desire: bool(desire.params["x"] == x)


@in_virtual_time
async def test_each_report_comes_once_for_each_desire_that_it_is_about() -> None:
    scene = Scene()
    async with scene.bench as bench:
        reports = bench.listen("accomplishments")
        bench.graph.channel("accomplishments").observe(scene.workspace.accomplish)
        one, two, other = scene.desire(params={"x": 1}), scene.desire(params={"x": 1}), scene.desire(params={"x": 2})
        scene.desire(params={"x": 1}, utility=0)
        scene.desire("Nod")
        reporter = scene.waver.accomplishments
        for _ in range(3):
            reporter.report("done", "waved", at(1))
        got = drain(reports)
        assert [(r.desire_id, r.behavior, r.outcome, r.reason) for r in got] == [
            (one, "Tested", "done", "waved"),
            (two, "Tested", "done", "waved"),
        ]
        reporter.report("failed", "stuck", at(1))
        scene.workspace.remove(two)
        reporter.report("done", "", at(1))
        assert [(r.desire_id, r.outcome) for r in drain(reports)] == [(one, "failed"), (two, "failed"), (one, "done")]
        scene.workspace.change(one, params={"x": 3})
        reporter.report("done", "", at(3))
        reporter.report("done", "", at(2))
        assert [r.desire_id for r in drain(reports)] == [one, other]


@in_virtual_time
async def test_a_desire_that_was_changed_meanwhile_is_reported_again() -> None:
    scene = Scene()
    async with scene.bench as bench:
        bench.graph.channel("accomplishments").observe(scene.workspace.accomplish)
        desire = scene.desire(params={"x": 1})
        scene.waver.accomplishments.report("done", "", at(1))
        scene.workspace.change(desire, params={"x": 2})
        scene.workspace.change(desire, params={"x": 1})
        assert scene.workspace.report(desire).outcome is None
        scene.waver.accomplishments.report("done", "", at(1))
        assert scene.workspace.report(desire).outcome == "done"


@in_virtual_time
async def test_without_a_channel_it_reports_nothing_and_a_caution_says_so() -> None:
    scene = Scene(wired=False)
    async with scene.bench:
        scene.waver.accomplishments.report("done", "", at(1))
        (caution,) = scene.waver.accomplishments.cautions()
        assert "accomplishments of Tested leads to no channel" in caution.text
    assert Scene().waver.accomplishments.cautions() == ()
