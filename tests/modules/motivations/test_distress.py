"""When a goal is reached, insisted on, given up: the decision alone, stepped through time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from app.base.geometry import Pose2
from app.messages import NavigationStatus
from app.modules.motivations.distress import (
    Act,
    DistressState,
    DistressTimes,
    GiveUp,
    GoalProgress,
    Level,
    Raise,
    Restore,
    decide,
    same_goal,
    status_of,
)

GOAL = Pose2(3.0, 4.0, math.nan)
GIVEN = 100.0
PATIENCE = DistressTimes(insist_s=20, inhibit_s=40, give_up_s=90, unreachable_s=5, relief_s=20, unserved_s=5)


def status(
    stamp: float,
    state: str = "following",
    progress: float | None = GIVEN,
    reason: str = "",
    goal: Pose2 = GOAL,
    left_m: float | None = None,
) -> NavigationStatus:
    # It is neared by as much as there was progress, unless said.
    left_m = 50.0 - 0.1 * ((progress or GIVEN) - GIVEN) if left_m is None else left_m
    return NavigationStatus(stamp, "PlanAndFollowPath", state, reason, goal, goal, left_m, progress)


@dataclass
class Story:
    """Decisions on an errand, every 0.25 s: ``acts`` are (s since it was given, what was done)."""

    times: DistressTimes = PATIENCE

    def __post_init__(self) -> None:
        self.now = GIVEN
        self.state = DistressState()
        self.acts: list[tuple[float, Act]] = []

    def until(
        self,
        seconds: float,
        says: Callable[[float], NavigationStatus | None] = status,
        *,
        goal: Pose2 | None = GOAL,
        given: float = GIVEN,
        by_hand: bool = False,
        blocked: str = "",
    ) -> None:
        while self.now < GIVEN + seconds:
            self.now += 0.25
            goal_progress = None if goal is None else GoalProgress(goal, given, says(self.now), blocked)
            self.state, acts = decide(self.now, goal_progress, self.state, self.times, by_hand=by_hand)
            self.acts += [(round(self.now - GIVEN, 2), act) for act in acts]

    def said(self) -> Iterator[tuple[float, str]]:
        for when, act in self.acts:
            yield when, act.level.name if isinstance(act, Raise) else type(act).__name__


def test_progress_keeps_it_calm() -> None:
    story = Story()
    story.until(500, lambda now: status(now, progress=now - 15.0))
    assert story.acts == []


def test_at_the_goal_there_is_nothing_to_do() -> None:
    story = Story()
    story.until(30, lambda now: status(now, progress=now))
    story.until(500, lambda now: status(now, "arrived"))
    assert story.acts == []


def test_without_progress_it_insists_then_inhibits_then_gives_up() -> None:
    story = Story()
    story.until(90, lambda now: status(now, "recovering", reason="backing off"), blocked="stopped: something ahead")
    assert list(story.said()) == [(20, "INSISTING"), (40, "INHIBITING"), (90, "Restore"), (90, "GiveUp")]
    assert story.acts[0][1] == Raise(Level.INSISTING, 20.0)
    assert story.acts[-1][1] == GiveUp("no progress for 90 s (backing off; stopped: something ahead)")
    assert story.state == DistressState()


def test_a_status_without_progress_counts_from_when_the_goal_was_given() -> None:
    story = Story()
    story.until(21, lambda now: status(now, "planning", progress=None))
    assert list(story.said()) == [(20, "INSISTING")]


def test_getting_on_again_restores_everything_but_not_at_once() -> None:
    story = Story()
    story.until(25)
    story.until(39, lambda now: status(now, progress=now))
    assert list(story.said()) == [(20, "INSISTING")]
    story.until(60, lambda now: status(now, progress=now))
    assert story.acts[1:] == [(40, Restore("it gets on again"))]
    story.until(81, lambda now: status(now, progress=GIVEN + 60))
    assert list(story.said())[2:] == [(80, "INSISTING")], "and the next distress is a new one"


def test_creeping_is_no_getting_on() -> None:
    story = Story()
    story.until(21, lambda now: status(now, left_m=3.0))
    # 0.2 m in two minutes, which a behavior calls progress now and then.
    story.until(141, lambda now: status(now, progress=now - (now % 20), left_m=3.0 - 0.2 * (now - GIVEN - 21) / 120))
    assert list(story.said()) == [(20, "INSISTING")], "it neither ends nor begins again"
    # A detour is a longer way; half a metre of that is getting on.
    story.until(142, lambda now: status(now, progress=now, left_m=5.0))
    story.until(150, lambda now: status(now, progress=now, left_m=4.6))
    assert len(story.acts) == 1
    story.until(151, lambda now: status(now, progress=now, left_m=4.4))
    assert story.acts[1:] == [(150.25, Restore("it gets on again"))]


@pytest.mark.parametrize("after", ["arrived", "another", "none", "unreachable"])
def test_whatever_ends_the_errand_restores_everything(after: str) -> None:
    story = Story()
    story.until(50)
    if after == "arrived":
        story.until(50.25, lambda now: status(now, "arrived"))
        assert list(story.said())[2:] == [(50.25, "Restore")]
    elif after == "another":
        story.until(60, lambda now: None, goal=Pose2(1, 1, 0.0), given=GIVEN + 50)
        assert list(story.said())[2:] == [(50.25, "Restore")]
    elif after == "none":
        story.until(60, goal=None)
        assert list(story.said())[2:] == [(50.25, "Restore")]
    else:
        story.until(60, lambda now: status(now, "unreachable", reason="walled in"))
        assert list(story.said())[2:4] == [(55.25, "Restore"), (55.25, "GiveUp")]
        assert story.acts[3][1] == GiveUp("walled in")


def test_the_same_goal_given_again_is_another_errand() -> None:
    story = Story()
    story.until(50)
    story.until(69, lambda now: status(now, progress=None), given=GIVEN + 50)
    assert list(story.said())[2:] == [(50.25, "Restore")]
    story.until(71, lambda now: status(now, progress=None), given=GIVEN + 50)
    assert list(story.said())[3:] == [(70, "INSISTING")]


def test_unreachable_is_given_up_when_it_stays_so() -> None:
    story = Story()
    story.until(4, lambda now: status(now, "unreachable", reason="walled in"))
    story.until(6, status)
    assert story.acts == []
    story.until(11, lambda now: status(now, "unreachable", reason=""))
    assert story.acts == []
    story.until(11.25, lambda now: status(now, "unreachable", reason=""))
    assert story.acts == [(11.25, GiveUp("it cannot be reached"))]


@pytest.mark.parametrize("state", ["following", "unreachable"])
def test_people_who_drive_are_no_distress(state: str) -> None:
    story = Story()
    story.until(300, lambda now: status(now, state), by_hand=True)
    assert story.acts == []
    story.until(319, lambda now: status(now), by_hand=False)
    assert story.acts == []
    story.until(321, lambda now: status(now))
    assert list(story.said()) == [(320, "INSISTING")]


def test_a_class_that_nothing_serves_is_left_to_attention() -> None:
    story = Story()
    story.until(500, lambda now: None)
    assert story.acts == []
    story.until(600, lambda now: status(now, "idle"))
    assert story.acts == []


def test_insisting_that_leaves_no_driver_is_taken_back_and_not_tried_again() -> None:
    story = Story()
    story.until(22)
    story.until(26, lambda now: None)
    assert list(story.said()) == [(20, "INSISTING")], "another behavior takes a moment to take over"
    story.until(28, lambda now: None)
    assert list(story.said())[1:] == [(27.25, "Restore")]
    story.until(90)
    assert list(story.said())[2:] == [(90, "GiveUp")]


def test_the_status_of_a_goal_is_the_newest_about_it_since_it_was_given() -> None:
    old, other = status(GIVEN - 1, "arrived"), status(GIVEN + 3, goal=Pose2(0, 0, math.nan))
    idle = NavigationStatus(GIVEN + 4, "GoToward", "idle", "no goal")
    assert status_of(GOAL, GIVEN, [old, other, idle]) is None
    first, second = status(GIVEN + 1), status(GIVEN + 2)
    assert status_of(GOAL, GIVEN, [second, first, old, other, idle]) is second


def test_goals_are_the_same_with_the_same_heading_or_none() -> None:
    assert same_goal(GOAL, Pose2(3.0, 4.0, math.nan))
    assert same_goal(Pose2(3, 4, math.pi), Pose2(3, 4, -math.pi))
    assert not same_goal(GOAL, Pose2(3, 4, 0.0))
    assert not same_goal(Pose2(3, 4, 0.1), Pose2(3, 4, 0.0))
    assert not same_goal(GOAL, Pose2(3.1, 4, math.nan))
