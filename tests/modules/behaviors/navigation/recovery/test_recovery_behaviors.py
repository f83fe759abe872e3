from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2, wrap_angle
from app.modules.behaviors.navigation.recovery.driven_area import DrivenArea, back_toward
from app.modules.behaviors.navigation.recovery.recovery_behaviors import (
    LADDER,
    Recovery,
    RecoveryAction,
    RecoverySettings,
    SpinSearch,
)

SETTINGS = RecoverySettings(rounds=2)


def test_measures_get_stronger_then_people_are_asked_and_it_begins_again() -> None:
    recovery = Recovery(SETTINGS)
    taken = []
    for _ in range(2 * len(LADDER) + 2):
        taken.append(recovery.begin(0.0))
        recovery.end()
    assert taken == [*LADDER, *LADDER, RecoveryAction.ASK, RecoveryAction.WAIT]
    assert recovery.count == 2 * len(LADDER) + 1, "asking is no recovery"


def test_what_got_it_on_makes_the_next_measure_the_mildest_again() -> None:
    recovery = Recovery(SETTINGS)
    for _ in range(3):
        recovery.begin(0.0)
        recovery.end()
    recovery.succeeded()
    assert recovery.begin(5.0) is RecoveryAction.WAIT
    assert recovery.count == 4
    recovery.reset()
    assert (recovery.current, recovery.count) == (None, 0)


@pytest.mark.parametrize(
    ("measure", "not_yet", "then"),
    [
        (RecoveryAction.WAIT, {"now": 1.4}, {"now": 1.6}),
        (RecoveryAction.BACK_OFF, {"now": 1.0, "driven_m": 0.3}, {"now": 1.0, "driven_m": 0.41}),
        (RecoveryAction.BACK_OFF, {"now": 3.9}, {"now": 4.1}),
        (RecoveryAction.BACK_OFF, {"now": 0.1}, {"now": 0.1, "barred": True}),
        (RecoveryAction.TURN, {"now": 1.0, "turned_rad": 1.5}, {"now": 1.0, "turned_rad": 1.7}),
        (RecoveryAction.TURN, {"now": 0.1}, {"now": 0.1, "barred": True}),
        (RecoveryAction.ASK, {"now": 14.0}, {"now": 15.1}),
    ],
)
def test_a_measure_is_over_when_it_has_done_what_it_can(
    measure: RecoveryAction, not_yet: dict[str, Any], then: dict[str, Any]
) -> None:
    recovery = Recovery(RecoverySettings(rounds=1))
    while recovery.begin(0.0) is not measure:
        recovery.end()
    assert not recovery.over(**not_yet)
    assert recovery.over(**then)


def test_the_way_back_is_the_way_it_came_and_ends() -> None:
    driven_area = DrivenArea(length_m=1.0)
    for k in range(60):
        driven_area.add(Pose2(0.05 * k, 0.0, 0.0))
    back = driven_area.back_from(Pose2(2.95, 0.0, 0.0), 0.3)
    assert back is not None
    assert 2.55 <= back.x <= 2.65
    pose, steps = Pose2(2.95, 0.0, 0.0), 0
    while (past := driven_area.back_from(pose, 0.3)) is not None and steps < 100:
        pose = Pose2(pose.x - 0.05, 0.0, 0.0)
        assert past.x >= 1.6, "no further than what it remembers"
        steps += 1
    assert driven_area.back_from(pose, 0.3) is None


@pytest.mark.parametrize("seen_there", [False, True])
def test_ground_that_the_body_was_brought_away_from_is_no_way_back(*, seen_there: bool) -> None:
    driven_area = DrivenArea()
    for k in range(40):
        driven_area.add(Pose2(0.05 * k, 0.0, 0.0))
    carried = Pose2(2.0, 8.0, 0.0)
    if seen_there:
        driven_area.add(carried)
    assert driven_area.back_from(carried, 0.3) in (None, carried)
    assert driven_area.back_from(Pose2(1.95, 0.0, 0.0), 0.3) is None, "nor if it comes by there again"


@given(st.floats(0.2, 1.0), st.floats(-0.8, 0.8), st.floats(-3, 3))
def test_backing_off_brings_it_to_the_place_behind(distance: float, bearing: float, heading: float) -> None:
    direction = heading + math.pi + bearing
    past = Pose2(distance * math.cos(direction), distance * math.sin(direction), heading)
    pose = Pose2(0.0, 0.0, heading)
    least = distance
    for _ in range(400):
        linear, angular = back_toward(pose, past, 0.1, 1.0)
        assert linear <= 0
        middle = pose.theta + 0.025 * angular
        pose = Pose2(
            pose.x + 0.05 * linear * math.cos(middle),
            pose.y + 0.05 * linear * math.sin(middle),
            wrap_angle(pose.theta + 0.05 * angular),
        )
        least = min(least, math.dist((pose.x, pose.y), (past.x, past.y)))
    assert least < 0.1


def test_lost_it_turns_after_a_moment_so_far_and_no_further_and_again_when_people_had_time_to_help() -> None:
    search = SpinSearch(RecoverySettings(wait_s=1.5, ask_s=15.0, find_rad=6.0))
    for began in (10.0, 10.0 + 9.0 + 15.0):
        assert not search.turns(began)
        assert not search.turns(began + 1.4)
        assert search.turns(began + 1.5)
        search.turned(5.9, began + 8.9)
        assert search.turns(began + 9.0)
        search.turned(0.2, began + 9.0)
        assert not search.turns(began + 9.1)
    search.end()
    assert not search.turns(50.0)
    assert search.turns(51.5), "lost again, it begins again"


def test_barred_it_turns_the_other_way_once() -> None:
    search = SpinSearch(RecoverySettings(wait_s=0.0, ask_s=15.0))
    assert search.turns(0.0)
    assert search.barred(1.0)
    assert search.turns(1.0)
    assert not search.barred(3.0)
    assert not search.turns(3.0)
    assert search.turns(18.0)
