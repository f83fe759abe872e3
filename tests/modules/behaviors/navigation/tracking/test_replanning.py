"""When a path is planned again."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal
from app.modules.behaviors.navigation.tracking.replanning import MOVED, Planned, why_plan

END = Pose2(3.0, 1.0, 0.0)
LAST = Planned(10.0, NavigationGoal(END, 0.25, 0.2), END, Pose2())


def asked(now: float, end: Pose2 = END, last: Planned | None = LAST, **more: Any) -> str | None:
    usual: dict[str, Any] = {"wanted": "", "is_following": True, "period_s": 1.0, "blocked_period_s": 0.3}
    X_MO = more.pop("X_MO", Pose2())
    return why_plan(now, end, last, X_MO, **(usual | more))


def test_another_goal_is_planned_for_at_once() -> None:
    assert asked(0.0, last=None) == "another goal"


def test_a_better_path_is_looked_for_once_a_period() -> None:
    assert [asked(10.0 + since) for since in (0.0, 0.9, 1.0, 5.0)] == [None, None, "", ""]


def test_a_goal_that_moves_is_planned_for_as_often_as_a_blocked_path() -> None:
    elsewhere = Pose2(3.0, 1.2, 0.0)
    assert [asked(10.0 + since, elsewhere) for since in (0.2, 0.3)] == [None, MOVED]


def test_what_blocks_the_path_replaces_one_that_is_not_followed() -> None:
    assert asked(10.2, wanted="blocked", is_following=False) is None
    assert asked(10.3, wanted="blocked", is_following=False) == "blocked"
    assert asked(10.3, wanted="blocked", is_following=True) == "", "another path must be better"


@pytest.mark.parametrize(("x", "theta", "jumped"), [(0.2, 0.0, True), (0.0, -0.11, True), (0.1, 0.05, False)])
def test_a_jump_of_the_pose_is_a_reason_before_the_period_is_over(x: float, theta: float, jumped: bool) -> None:
    found = asked(10.01, X_MO=Pose2(x, 0.0, theta))
    assert found == ("localization corrected itself" if jumped else None)


def test_jumps_are_counted_from_the_newest_request() -> None:
    assert asked(10.01, last=replace(LAST, X_MO=Pose2(0.2, 0.0, 0.0)), X_MO=Pose2(0.2, 0.0, 0.0)) is None
    assert asked(10.01, X_MO=None) is None
