"""Planning beside the control cycle: one at a time, answers to the goal that is still given, failures reported."""

from __future__ import annotations

import asyncio
from typing import Any

import numpy as np

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, read_only
from app.modules.behaviors.navigation.planning.global_planner import PlanRequest, PlanResult
from app.modules.behaviors.navigation.planning.goal_planning import GlobalPlan
from app.modules.behaviors.navigation.tracking.background_planner import BackgroundPlanner
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal, TrackingStep
from app.runtime.clock import in_virtual_time

GOAL, OTHER = (NavigationGoal(Pose2(x, 1.0, 0.0), 0.25, 0.2) for x in (3.0, 4.0))
FOLLOWS, WAITS = (TrackingStep(0.0, 0.0, state, "") for state in ("following", "waiting"))
GRID = OccupancyGrid(0.0, "map", read_only(np.zeros((2, 2), np.int8)), 0.05, (0.0, 0.0), 1)
WAY = GlobalPlan("way", "", np.zeros((5, 3)), Pose2(3.0, 1.0, 0.0), 3.0)
ANSWER = PlanResult(WAY, changed=True, why="", speed_share=lambda points: np.ones(len(points)))


class Planner:
    """A planner that answers when a test lets it."""

    def __init__(self) -> None:
        self.requests: list[PlanRequest] = []
        self.failures: list[Exception] = []
        self.answers: asyncio.Queue[PlanResult | Exception] = asyncio.Queue()
        self.tested = BackgroundPlanner(
            self._find, self.failures.append, period_s=1.0, blocked_period_s=0.3, name="the tested plans"
        )

    async def _find(self, request: PlanRequest) -> PlanResult:
        self.requests.append(request)
        answer = await self.answers.get()
        if isinstance(answer, Exception):
            raise answer
        return answer

    def due(self, now: float, goal: NavigationGoal = GOAL, step: TrackingStep = FOLLOWS) -> str | None:
        return self.tested.due(now, goal, goal.pose, Pose2(), step)

    def begin(self, now: float, goal: NavigationGoal = GOAL, **more: Any) -> None:
        self.tested.begin(now, goal, PlanRequest(GRID, (), X_MO=Pose2(), X_MB=Pose2(), goal=goal.pose, **more))

    async def answer(self, answer: PlanResult | Exception = ANSWER) -> None:
        self.answers.put_nowait(answer)
        await asyncio.sleep(0.01)


@in_virtual_time
async def test_one_path_is_planned_at_a_time_and_taken_over_once() -> None:
    planner = Planner()
    assert planner.due(0.0) == "another goal"
    planner.begin(0.0)
    assert planner.due(5.0) is None, "one is being planned"
    assert planner.tested.take_answer(GOAL) is None
    await planner.answer()
    assert planner.tested.take_answer(GOAL) is ANSWER
    assert planner.tested.take_answer(GOAL) is None
    planner.tested.plan = WAY
    assert [planner.due(now) for now in (0.9, 1.0)] == [None, ""]
    assert len(planner.requests) == 1


@in_virtual_time
async def test_an_answer_for_a_goal_that_is_no_more_is_of_no_use() -> None:
    planner = Planner()
    for given in (OTHER, None):
        planner.begin(0.0)
        await planner.answer()
        assert planner.tested.take_answer(given) is None
        assert planner.tested.take_answer(GOAL) is None, "it is dropped"


@in_virtual_time
async def test_the_plan_to_another_goal_is_dropped() -> None:
    planner = Planner()
    planner.begin(0.0)
    await planner.answer()
    planner.tested.plan = WAY
    assert planner.due(0.1, OTHER) == "another goal"
    assert planner.tested.plan is None


@in_virtual_time
async def test_changed_zones_are_a_reason_until_a_path_is_planned_for_them() -> None:
    planner = Planner()
    planner.begin(0.0)
    await planner.answer()
    planner.tested.want("zones changed")
    planner.tested.want("another reason")
    assert planner.due(0.5, step=WAITS) == "zones changed"
    planner.tested.plan = WAY
    assert planner.due(0.5, step=FOLLOWS) == "", "a path that is followed is replaced by a better one alone"
    planner.begin(0.5)
    await planner.answer()
    assert planner.due(1.0, step=WAITS) is None


@in_virtual_time
async def test_without_a_goal_there_is_no_plan() -> None:
    planner = Planner()
    assert not planner.tested.drop()
    planner.begin(0.0)
    await planner.answer()
    planner.tested.plan = WAY
    assert planner.tested.drop()
    assert not planner.tested.drop()
    assert planner.due(0.1) == "another goal"


@in_virtual_time
async def test_what_the_planner_raises_is_reported_and_what_is_cancelled_is_not() -> None:
    planner = Planner()
    failure = ValueError("no way to say it")
    planner.begin(0.0)
    await planner.answer(failure)
    assert planner.failures == [failure]
    assert planner.tested.take_answer(GOAL) is None
    planner.begin(1.0)
    planner.tested.cancel()
    await planner.answer()
    assert planner.failures == [failure]
    assert planner.due(9.0) == "", "the next may begin"
