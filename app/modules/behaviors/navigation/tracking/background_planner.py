"""Paths of a behavior, planned beside its control cycle: one at a time, each taken over by a later cycle."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.planning.global_planner import PlanRequest, PlanResult
from app.modules.behaviors.navigation.planning.goal_planning import GlobalPlan
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal, TrackingStep
from app.modules.behaviors.navigation.tracking.replanning import Planned, why_plan


class BackgroundPlanner:
    """``find`` plans, in another thread; what it raises is given to ``fail``. ``period_s``, ``blocked_period_s``: as of
    :func:`why_plan`. ``name``: of the task. ``plan``: the plan that is followed; None without any."""

    def __init__(
        self,
        find: Callable[[PlanRequest], Coroutine[Any, Any, PlanResult]],
        fail: Callable[[Exception], None],
        *,
        period_s: float,
        blocked_period_s: float,
        name: str,
    ) -> None:
        self._find = find
        self._fail = fail
        self._period_s = period_s
        self._blocked_period_s = blocked_period_s
        self._name = name
        self._task: asyncio.Task[PlanResult] | None = None
        self._planned: Planned | None = None
        self._answer: PlanResult | None = None
        self._wanted = ""
        self.plan: GlobalPlan | None = None

    def want(self, reason: str) -> None:
        """Plan again soon, for ``reason``."""
        self._wanted = self._wanted or reason

    def due(self, now: float, goal: NavigationGoal, end: Pose2, X_MO: Pose2 | None, step: TrackingStep) -> str | None:
        """Why a path to ``end`` of ``goal`` is to be planned at ``now`` (s), as :func:`why_plan`; None while one is
        being planned. ``step``: the result of this control cycle. A plan for another goal is dropped."""
        if self._task is not None:
            return None
        last = self._planned
        if last is None or last.goal is not goal:
            last, self.plan = None, None
        return why_plan(
            now,
            end,
            last,
            X_MO,
            wanted=step.replan or self._wanted,
            is_following=self.plan is not None and len(self.plan.poses) > 0 and step.state == "following",
            period_s=self._period_s,
            blocked_period_s=self._blocked_period_s,
        )

    def begin(self, now: float, goal: NavigationGoal, request: PlanRequest) -> None:
        """Plan a path for ``goal``."""
        self._planned = Planned(now, goal, request.goal, request.X_MO)
        self._wanted = ""
        self._task = asyncio.create_task(self._find(request), name=self._name)
        self._task.add_done_callback(self._end)

    def take_answer(self, goal: NavigationGoal | None) -> PlanResult | None:
        """What was planned for ``goal`` since the last call; None without any."""
        answer, self._answer = self._answer, None
        return answer if self._planned is not None and self._planned.goal is goal else None

    def drop(self) -> bool:
        """There is no goal any more; returns whether there was a plan."""
        had_plan = self.plan is not None
        self._planned, self.plan = None, None
        return had_plan

    def cancel(self) -> None:
        """End the planning that goes on."""
        if self._task is not None:
            self._task.cancel()

    def _end(self, task: asyncio.Task[PlanResult]) -> None:
        self._task = None
        if task.cancelled():
            return
        error = task.exception()
        if isinstance(error, Exception):
            self._fail(error)
        elif error is None:
            self._answer = task.result()
