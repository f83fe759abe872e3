"""Drives: how the level grows and is sated, and the desire that comes of it."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from app.attention.desires import Desire, DesireClass, DesireClasses
from app.attention.workspace import IntentionWorkspace
from app.messages import Twist
from app.modules.motivations.drive import Drive, DriveSettings, grown, urge
from app.runtime.clock import run_virtual
from app.runtime.module import ModuleContext
from tests.modules.fakes import Bench

SETTINGS = DriveSettings(grows_s=100, begins=0.5, ends=0.2, least=1, most=4)


class Minutes(BaseModel):
    minutes: float


class Playfulness(Drive):
    """Wants to be moved about; each twist sates a fifth."""

    drive_class = "Play"

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.twists = self.input("twists", Twist, always_open=True)
        self.on(self.twists, lambda _: self.sate(0.2))

    def drive_parameters(self) -> dict[str, Any]:
        return {"minutes": 5.0}


class Robot:
    def __init__(self, **settings: Any) -> None:
        play = DesireClass("Play", "Play with people", "Play.", Minutes)
        self.workspace = IntentionWorkspace(DesireClasses([play]), lambda: self.bench.clock.now())
        self.bench = Bench(
            f"{__name__}:Playfulness",
            inputs={"twists": Twist},
            services={IntentionWorkspace: self.workspace},
            settings=SETTINGS.model_dump() | settings,
        )

    async def after(self, seconds: float) -> Desire | None:
        await self.bench.clock.sleep(seconds)
        return self.workspace.wanted("Play")


def test_it_comes_as_the_need_has_grown_grows_with_it_and_goes_once_sated() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            assert await robot.after(48) is None
            first = await robot.after(4)
            assert first is not None
            assert (first.intensity, first.params, first.source.kind) == (1.0, {"minutes": 5.0}, "motivation")
            more = await robot.after(40)
            assert more is not None
            assert (more.id, more.intensity) == (first.id, 3.5)
            for _ in range(3):
                robot.bench.feed("twists", Twist(robot.bench.clock.now(), 0.1, 0.0))
                await robot.bench.clock.sleep(0.5)
            assert (await robot.after(1)) is not None, "less, and not yet little"
            for _ in range(2):
                robot.bench.feed("twists", Twist(robot.bench.clock.now(), 0.1, 0.0))
                await robot.bench.clock.sleep(0.5)
            assert await robot.after(1) is None
            assert await robot.after(60) is not None
        assert robot.workspace.desires() == ()

    run_virtual(main())


def test_who_withdraws_its_desire_has_peace_until_the_need_has_grown_again() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            wanted = await robot.after(60)
            assert wanted is not None
            robot.workspace.remove(wanted.id)
            assert await robot.after(45) is None
            assert await robot.after(10) is not None

    run_virtual(main())


def test_without_a_time_it_is_off() -> None:
    async def main() -> None:
        robot = Robot(grows_s=None)
        async with robot.bench:
            assert await robot.after(1000) is None

    run_virtual(main())


@given(st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=2, max_size=20))
def test_intensity_is_none_or_within_its_bounds_and_a_steady_level_settles(course: list[tuple[float, bool]]) -> None:
    before = 0.0
    for level, _ in course:
        before = urge(level, before, SETTINGS)
        assert before == 0.0 or SETTINGS.least <= before <= SETTINGS.most
        assert urge(level, before, SETTINGS) == before


@given(st.floats(0, 1), st.floats(0, 1e4), st.floats(0, 1e4))
def test_a_need_grows_and_never_beyond_one(level: float, first_s: float, then_s: float) -> None:
    once, twice = grown(level, first_s, SETTINGS), grown(grown(level, first_s, SETTINGS), then_s, SETTINGS)
    assert level <= once <= twice <= 1.0


@pytest.mark.parametrize("wrong", [{"begins": 0.1, "ends": 0.2}, {"least": 3, "most": 2}, {"grows_s": 0}])
def test_settings_that_contradict_each_other_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        DriveSettings(**wrong)
