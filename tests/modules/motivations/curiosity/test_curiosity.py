"""Curiosity in a graph of its own: the desires that it states, and when exploring is done."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Desire, DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import Accomplishment, Exploitation, Localization, OccupancyGrid, Twist, Zones
from app.modules.behaviors.gaze.look_where_going import LOOK_WHERE_GOING
from app.modules.behaviors.go_to import GO_TO
from app.modules.motivations.curiosity.curiosity import EXPLORE
from app.runtime.clock import run_virtual
from app.runtime.filter import CLOSED
from tests.modules.fakes import Bench, FakeLink

MODULE = "app.modules.motivations.curiosity.curiosity:Curiosity"
PERSON = Source("operator", "a person")
CELL_M = 0.1
SIDE_M = 0.25


def corridor(known_m: float) -> NDArray[np.int8]:
    """10 x 2 m between walls, known from its left end to ``known_m``, the right end a wall as well."""
    cells = np.full((24, 104), 100, np.int8)
    cells[2:22, 2:102] = 0
    cells[:, 2 + round(known_m / CELL_M) :] = -1 if known_m < 10 else cells[:, -1:]
    return cells


class Robot:
    """The module, a workspace, and a map that the test draws; the robot is in the corridor's left end, at (0, 0)."""

    def __init__(self, **settings: Any) -> None:
        self.workspace = IntentionWorkspace(
            DesireClasses([EXPLORE, GO_TO, LOOK_WHERE_GOING]), lambda: self.bench.clock.now()
        )
        link = FakeLink()
        square = ((SIDE_M, -SIDE_M), (SIDE_M, SIDE_M), (-SIDE_M, SIDE_M), (-SIDE_M, -SIDE_M))
        link.description = replace(link.description, footprint=square)
        self.bench = Bench(
            MODULE,
            inputs={"map": OccupancyGrid, "localization": Localization, "zones": Zones, "base": Exploitation},
            services={IntentionWorkspace: self.workspace},
            settings=settings,
            link=link,
        )

    def explore(self, **given: Any) -> Desire:
        return self.workspace.add("Explore", intensity=5, utility=1, source=PERSON, params=given)

    async def sees(self, known_m: float, *, state: str = "mapping") -> Desire | None:
        """The desire for a place once the module has looked at this map."""
        now = self.bench.clock.now()
        self.bench.feed("localization", Localization(now, Pose2(), Pose2(), np.zeros((3, 3)), state, 1.0, ""))
        self.bench.feed("map", OccupancyGrid(now, "map", corridor(known_m), CELL_M, (-1.2, -1.2), round(now * 1e3)))
        await self.bench.clock.sleep(1.5)
        return self.workspace.wanted("GoTo")

    def reports(self, goal: Desire, outcome: Any) -> None:
        self.workspace.accomplish(Accomplishment(self.bench.clock.now(), goal.id, "PlanAndFollowPath", outcome, "so"))


def test_it_goes_to_where_the_map_ends_further_as_it_grows_until_nothing_is_left() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            assert await robot.sees(3.0) is None, "nobody wants it to"
            wanted = robot.explore()
            first = await robot.sees(3.0)
            assert first is not None
            assert (first.intensity, first.source.kind, first.source.name) == (5, "motivation", "Tested")
            assert 1.5 < first.params["x"] < 2.3
            assert abs(first.params["heading"]) < 0.6, "it looks to what is not known"
            assert robot.workspace.wanted("LookWhereGoing") is not None
            further = await robot.sees(6.0)
            assert further is not None
            assert further.id == first.id, "one goal, which moves on"
            assert 4.5 < further.params["x"] < 5.3
            robot.workspace.change(wanted.id, intensity=7)
            more = await robot.sees(6.0)
            assert more is not None
            assert more.intensity == 7
            robot.workspace.change(wanted.id, intensity=2)
            less = await robot.sees(6.0)
            assert less is not None
            assert less.intensity == 2
            assert await robot.sees(10.0) is None
            assert robot.workspace.wanted("Explore") is not None, "it waits: the map may still grow"
            await robot.bench.clock.sleep(6.0)
            (done,) = [each for each in robot.workspace.ended(9) if each.id == wanted.id]
            assert (done.outcome, robot.workspace.desires()) == ("done", ())
            assert done.reason.startswith("all that it can reach is mapped: 20 m² of floor in ")

    run_virtual(main())


def test_what_cannot_be_reached_is_tried_once_more_and_said_at_the_end() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            wanted = robot.explore()
            for _ in range(2):
                goal = await robot.sees(3.0)
                assert goal is not None
                robot.reports(goal, "failed")
            assert await robot.sees(3.0) is None
            await robot.bench.clock.sleep(6.0)
            (done,) = [each for each in robot.workspace.ended(9) if each.id == wanted.id]
            assert done.outcome == "done"
            assert done.reason.endswith("; 1 place could not be looked at")

    run_virtual(main())


def test_a_frontier_before_which_it_stands_for_long_is_refused() -> None:
    async def main() -> None:
        robot = Robot(patience_s=5)
        async with robot.bench:
            wanted = robot.explore()
            still = Twist(0.0, 0.0, 0.0)
            robot.bench.feed("base", Exploitation(robot.bench.clock.now(), "PlanAndFollowPath", still))
            for _ in range(2):
                goal = await robot.sees(3.0)
                assert goal is not None
                await robot.bench.clock.sleep(7.0)
                assert robot.workspace.report(goal.id).ended is not None
            await robot.bench.clock.sleep(6.0)
            assert robot.workspace.report(wanted.id).outcome == "done"

    run_virtual(main())


def test_exploring_ends_where_people_withdraw_its_goal() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            wanted = robot.explore()
            goal = await robot.sees(3.0)
            assert goal is not None
            robot.workspace.remove(goal.id)
            assert await robot.sees(3.0) is None
            assert robot.workspace.desires() == (), "nor will it begin again by itself"
            assert robot.workspace.report(wanted.id).outcome == "withdrawn"

    run_virtual(main())


def test_its_goal_goes_with_the_desire_with_attention_and_with_the_module() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            wanted = robot.explore()
            assert await robot.sees(3.0) is not None
            assert await robot.sees(3.0, state="lost") is not None, "the pose may come back"
            robot.workspace.remove(wanted.id)
            assert await robot.sees(3.0) is None
            robot.explore()
            assert await robot.sees(3.0) is not None
            (localization,) = [port for name, port in robot.bench.slot.context.inputs.items() if name == "localization"]
            localization.subscription.filter.divisor = CLOSED
            await robot.bench.clock.sleep(1.5)
            assert robot.workspace.wanted("GoTo") is None, "attention has no room for exploring"
            localization.subscription.filter.divisor = 1
            assert await robot.sees(3.0) is not None
        assert robot.workspace.wanted("GoTo") is None

    run_virtual(main())


def test_what_ends_while_it_searches_is_not_begun_again() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            for end in ("Explore", "GoTo"):
                robot.explore()
                first = await robot.sees(3.0)
                assert first is not None
                module, ended = robot.bench.slot.module, end

                async def compute(
                    function: Callable[..., Any], *args: Any, module: Any = module, ended: str = ended
                ) -> Any:
                    del module.compute
                    desire = robot.workspace.wanted(ended)
                    assert desire is not None
                    robot.workspace.remove(desire.id)
                    return function(*args)

                setattr(module, "compute", compute)  # noqa: B010  # people do that meanwhile
                assert await robot.sees(6.0) is None
                assert robot.bench.slot.module is module, "it did not fail"
                assert robot.workspace.desires() == (), end

    run_virtual(main())


def test_while_another_behavior_drives_or_another_goal_is_stronger_it_does_not_lose_patience() -> None:
    async def main() -> None:
        robot = Robot(patience_s=5)
        async with robot.bench:
            robot.explore()
            goal = await robot.sees(3.0)
            assert goal is not None
            still = Twist(0.0, 0.0, 0.0)
            robot.bench.feed("base", Exploitation(robot.bench.clock.now(), "Docking", still))
            await robot.bench.clock.sleep(20.0)
            assert robot.workspace.report(goal.id).ended is None, "it charges"
            robot.bench.feed("base", Exploitation(robot.bench.clock.now(), "PlanAndFollowPath", still))
            theirs = robot.workspace.add("GoTo", intensity=8, utility=1, source=PERSON, params={"x": 0, "y": 0})
            await robot.bench.clock.sleep(20.0)
            assert robot.workspace.report(goal.id).ended is None, "it waits where people sent it"
            robot.workspace.remove(theirs.id)
            await robot.bench.clock.sleep(7.0)
            assert robot.workspace.report(goal.id).ended is not None

    run_virtual(main())


def test_no_further_than_it_may() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            robot.explore(within_m=4.0)
            goal = await robot.sees(3.0)
            assert goal is not None
            assert math.hypot(goal.params["x"], goal.params["y"]) <= 4.0
            assert await robot.sees(7.0) is None

    run_virtual(main())


def test_left_alone_it_wants_to_explore_by_itself_where_that_is_turned_on() -> None:
    async def main() -> None:
        robot = Robot(grows_s=100, begins=0.5)
        async with robot.bench:
            still = Twist(0.0, 0.0, 0.0)
            robot.bench.feed("base", Exploitation(robot.bench.clock.now(), "Teleop", still))
            await robot.bench.clock.sleep(80.0)
            assert robot.workspace.wanted("Explore") is None, "somebody drives it"
            robot.bench.feed("base", Exploitation(robot.bench.clock.now(), None, still))
            await robot.bench.clock.sleep(53.0)
            wanted = robot.workspace.wanted("Explore")
            assert wanted is not None
            assert (wanted.intensity, wanted.source.kind) == (1.0, "motivation")
            assert await robot.sees(3.0) is not None
            assert await robot.sees(10.0) is None
            await robot.bench.clock.sleep(40.0)
            assert robot.workspace.desires() == (), "it has seen all, for a while"

    run_virtual(main())
