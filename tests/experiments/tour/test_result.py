"""Runs are judged by what was seen of them."""

from __future__ import annotations

from typing import Any

import pytest

from app.experiments.tour.result import (
    Arrival,
    SaidText,
    TourSummary,
    farthest_m,
    left_behind_s,
    waits,
)
from tests.experiments.tour.runs import good, sample


def test_a_run_as_it_should_be_has_no_problem() -> None:
    assert good().problems == ()
    paused = SaidText("Hello.", ended=False, reason="it was paused")
    assert good(texts=(paused,)).problems == (), "interrupted, and it is known why"


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"outcome": "all visitors have left"}, "it ended otherwise: all visitors have left"),
        ({"presented": 1}, "1 of 2 stops were presented"),
        ({"arrivals": (Arrival("one", 0.31, 0.0),)}, "one: 0.31 m and 0.00 rad off"),
        ({"arrivals": (Arrival("one", 0.1, -0.21),)}, "one: 0.10 m and 0.21 rad off"),
        ({"texts": (SaidText("Hello.", ended=False),)}, "interrupted for no known reason: Hello."),
        ({"unsaid": ("It is warm.",)}, "never said: It is warm."),
        ({"pointed_deg": ()}, "pointed 0 of 1 times"),
        ({"pointed_deg": (11.0,)}, "pointed 11° beside"),
        ({"left_behind_s": 10.5}, "a visitor was farther than 4 m for 10.5 s, and the robot went on"),
        ({"touched": 2}, "touched something 2 times"),
        ({"cpu_share": 1.02}, "attention gave out 102 % of its CPU budget"),
        ({"answered": 0}, "0 of 1 questions were answered"),
        ({"failures": ("two: not reached",)}, "two: not reached"),
    ],
)
def test_each_thing_that_is_wrong_is_said(change: dict[str, Any], problem: str) -> None:
    assert good(**change).problems == (problem,)


def test_who_is_left_behind_is_counted_while_the_robot_goes_on() -> None:
    far = [sample(float(at), "leading", 1.0, 4.5) for at in range(8)]
    assert left_behind_s(far, wait_m=4.0) == 7.0
    waited = [sample(each.at_s, "waiting" if each.at_s in (3.0, 4.0) else "leading", 1.0, 4.5) for each in far]
    assert left_behind_s(waited, wait_m=4.0) == 2.0
    came = [sample(each.at_s, "leading", 1.0, 3.9 if each.at_s == 4.0 else 4.5) for each in far]
    assert left_behind_s(came, wait_m=4.0) == 3.0
    turns = [sample(float(at), "leading", *((4.5, 1.0) if at % 4 < 2 else (1.0, 4.5))) for at in range(8)]
    assert left_behind_s(turns, wait_m=4.0) == 1.0, "of one visitor at a time"
    assert left_behind_s([], wait_m=4.0) == 0.0


def test_distances_and_waits_are_those_of_the_way() -> None:
    seen = [
        sample(0.0, "inviting", 9.0),
        sample(1.0, "leading", 3.0),
        sample(2.0, "waiting", 6.0),
        sample(4.0, "leading", 2.0),
        sample(5.0, "waiting", 2.0),
        sample(5.5, "going_home", 8.0),
    ]
    assert farthest_m(seen) == 3.0
    assert waits(seen) == (2, 2.5)


def test_driving_back_for_visitors_is_waiting_for_them() -> None:
    states = ("leading", "waiting", "searching", "waiting", "leading")
    seen = [sample(5.0 * number, state, 6.0) for number, state in enumerate(states)]
    assert waits(seen) == (1, 15.0)
    assert left_behind_s(seen, 4.0) == 0.0


def test_a_summary_is_of_the_worst() -> None:
    bad = good(arrivals=(Arrival("one", 0.4, -0.3),), touched=1, people_m=None, texts=(SaidText("Hi.", ended=False),))
    found = TourSummary.of([good(), bad])
    assert (found.runs, found.good, found.stops_presented, found.touched) == (2, 1, 4, 1)
    assert (found.worst_off_m, found.worst_off_rad, found.least_people_m) == (0.4, 0.3, 0.4)
    assert (found.texts, found.interrupted) == (2, 1)
    assert TourSummary.of([]).mean_duration_s is None
