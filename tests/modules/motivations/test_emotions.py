"""The module of emotions beside a real Intention Workspace and Translator."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from app.attention.desire_progress import ProgressLog
from app.attention.desires import DesireClasses
from app.attention.reports import desires_report, intention_report
from app.attention.strategies import StrategyTable
from app.attention.workspace import IntentionWorkspace
from app.base.errors import ConfigError
from app.messages import Desires, EmotionLevel, EmotionSource, EmotionState, Modulation, RaisedIntensity
from app.program.config import load_configuration
from app.runtime.clock import VirtualClock, in_virtual_time
from app.runtime.graph import Graph
from tests.attention.setting import CLASSES, RIVALS, TABLE, Setting
from tests.modules.fakes import Bench, drain

MODULE = "app.modules.motivations.emotions:Emotions"
#: Driving by hand, which calms as published, does nothing here.
RIVALRY: dict[str, Any] = {
    "GoTo": {"exploited": {"anger": -0.02}, "neglected": {"anger": 0.05, "sadness": 0.01}},
    "Teleoperation": {},
}


PROGRAM = """\
robot: robot.yaml
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  Emotions:
    class: app.modules.motivations.emotions:Emotions
    outputs: {emotions: emotions}
"""


class Robot(Setting):
    """Desires, attention and, unless ``feels`` is false, emotions; what is intended is exploited."""

    def __init__(
        self, table: StrategyTable = RIVALS, classes: DesireClasses = CLASSES, *, feels: bool = True, **settings: Any
    ) -> None:
        super().__init__(table, classes)
        self._feels = feels
        self._progress = ProgressLog(10.0)
        self.emotions = Bench(
            MODULE,
            inputs={"desires": Desires},
            outputs={"emotions": EmotionState},
            services={IntentionWorkspace: self.workspace},
            settings=settings,
        )
        self.states: list[EmotionState] = []

    @asynccontextmanager
    async def alive(self) -> AsyncIterator[None]:
        async with self.running():
            if not self._feels:
                yield
                return
            heard = self.emotions.listen("emotions")
            async with self.emotions:
                self.heard = heard
                yield

    async def live(self, seconds: int) -> list[tuple[str, ...]]:
        """What is selected, once a second."""
        found = []
        for _ in range(seconds):
            await self.translator.settled()
            found.append(self.selected)
            now, current = self.clock.now(), self.translator.current
            assert current is not None
            at_work = {strategy.cls for strategy in current.strategies}
            intended = tuple(d.id for cls, d in self.workspace.strongest().items() if cls in at_work and d.utility > 0)
            self._progress.update(now, self.workspace.desires(), intended, intended)
            report = desires_report(self.workspace, now, intended, self._progress.progress)
            self.emotions.feed("desires", report)
            await asyncio.sleep(1.0)
        return found

    @property
    def state(self) -> EmotionState:
        self.states += drain(self.heard)
        return self.states[-1]


@in_virtual_time
async def test_an_ignored_desire_is_raised_with_the_reason_and_calms() -> None:
    robot = Robot(modulates=True, effects=RIVALRY)
    async with robot.alive():
        robot.add("Teleoperation", intensity=5)
        goal = robot.add("GoTo", intensity=4)
        await robot.live(12)
        assert robot.selected == ("teleop",)
        desire = robot.workspace.get(goal)
        assert desire.modulation == Modulation(1.0, "anger")
        assert (desire.intensity, robot.workspace.strongest()["GoTo"].intensity) == (4.0, 5.0)
        anger = robot.state.emotions[1]
        assert anger.emotion == "anger"
        assert 0.5 < anger.intensity < 0.8
        assert anger.sources == (EmotionSource("GoTo", anger.intensity, neglected=True),)
        assert robot.state.raised == (RaisedIntensity(goal, "GoTo", 1.0, "anger"),)
        assert robot.state.emotions[3] == EmotionLevel("fear", 0.0, ())

        await robot.live(3)
        assert robot.selected == ("goto",)
        assert robot.translator.current is not None
        asked = intention_report(robot.translator.current, RIVALS.resources).asked["GoTo"]
        assert (asked.intensity, asked.modulation) == (5.25, Modulation(1.25, "anger"))

        assert (await robot.live(120))[-1] == ("teleop",)
        assert robot.state.raised == ()
        assert robot.workspace.get(goal).modulation is None
        words = [event.text for event in robot.timeline.query(kinds={"emotion"})]
        assert words == [
            "GoTo is ignored: anger raises its intensity",
            "GoTo is raised no more by anger",
        ]
        assert len(set(await robot.live(300))) == 1


@in_virtual_time
async def test_off_by_its_key_attention_is_as_without_the_module() -> None:
    without, beside = Robot(TABLE, feels=False), Robot(TABLE, modulates=False)
    selections = {}
    for robot in (without, beside):
        async with robot.alive():
            robot.add("FindQRCodes", intensity=4)
            robot.add("LocateFaces", intensity=4, utility=4)
            robot.add("LocateVoices", intensity=3)
            found = await robot.live(30)
            robot.add("GoTo", intensity=3.5)
            found += await robot.live(30)
            robot.add("Teleoperation", intensity=2)
            selections[robot] = found + await robot.live(30)
    assert selections[without] == selections[beside]
    assert len(set(selections[without])) > 1
    assert all(desire.modulation is None for desire in beside.workspace.desires())
    assert beside.state.modulates is False
    assert beside.events("emotion") == []


@in_virtual_time
async def test_with_the_module_what_was_raised_goes_and_what_is_felt_outlasts_a_restart() -> None:
    robot = Robot(modulates=True, effects=RIVALRY)
    async with robot.running():
        robot.add("Teleoperation", intensity=8)
        goal = robot.add("GoTo", intensity=1)
        async with robot.emotions:
            await robot.live(30)
            assert robot.emotions.problem == ""
            assert robot.workspace.get(goal).modulation is not None
            await robot.emotions.supervisor.stop_modules()
            assert robot.workspace.get(goal).modulation is None
            heard = robot.emotions.listen("emotions")
            robot.emotions.supervisor.start_modules()
            await robot.emotions.settle()
            assert drain(heard)[0].emotions[1].intensity > 0.9


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ("{most: 9}", "most"),
        ("{decay_per_s: -0.1}", "decay_per_s"),
        ("{shows_most: 0.1}", "shows_most"),
        ("{shows_from: 0.2}", ""),
        ("{effects: {GoTo: {neglected: {anger: 2}}}}", "effects.GoTo.neglected.anger"),
        ("{effects: {GoTo: {neglected: {rage: 0.1}}}}", "effects.GoTo.neglected.rage"),
    ],
)
def test_a_setting_out_of_its_range_is_refused_with_file_and_line(tmp_path: Path, settings: str, said: str) -> None:
    (tmp_path / "channels.yaml").write_text("emotions: {type: EmotionState}\n")
    for name in ("robot.yaml", "strategies.yaml"):
        (tmp_path / name).write_text("")
    program = tmp_path / "program.yaml"
    program.write_text(PROGRAM + f"    settings:\n      {settings}\n")
    configuration = load_configuration(program)
    where = "settings" + (f"\\.{said}" if said else "")
    with pytest.raises(ConfigError, match=rf"program\.yaml:\d: modules\.Emotions\.{where}:") as refusal:
        Graph(
            clock=VirtualClock(),
            channels=configuration.channels,
            modules=configuration.program.modules,
            services={},
            error=configuration.wiring_error,
        )
    assert "rage" not in said or "joy" in str(refusal.value)


def test_a_class_that_there_is_not_is_cautioned_of() -> None:
    robot = Robot(effects={"Goto": {"neglected": {"anger": 0.1}}})
    (caution,) = robot.emotions.slot.module.cautions()
    assert "'Goto'" in caution.text
    assert "GoTo" in caution.text
    assert Robot(effects=RIVALRY).emotions.slot.module.cautions() == ()
