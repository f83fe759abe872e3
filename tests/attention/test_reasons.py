"""Reasons: every alternative offered is true, and the texts say what the fields say."""

from __future__ import annotations

import math

from hypothesis import given, settings

from app.attention.problem import Problem, produced
from app.attention.reasons import best_utility, explain
from app.attention.solver import solve
from app.attention.strategies import Resource, Strategy
from tests.attention.test_solver import problems
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem

RESOURCES = {"cpu": Resource("cpu", 100, "% of one core")}


def test_degraded_says_what_it_would_take() -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    reasons = explain(p, solve(p), time_limit_s=60, resources=RESOURCES)
    assert reasons["GoTo"].text == "fulfilled at its best (8) by 13"
    faces = reasons["LocateFaces"]
    assert (faces.state, faces.utility, faces.wanted, faces.best) == ("degraded", 4, 1, 8)
    assert faces.text == "fulfilled at 4 of 8 by 6; would get 8 with 10 % more cpu or without GoTo"
    assert [(a.kind, a.resource, a.amount, a.without) for a in faces.alternatives] == [
        ("capacity", "cpu", 10, ""),
        ("without", "", 0, "GoTo"),
    ]


def test_unfulfilled_for_want_of_a_resource() -> None:
    p = problem([desire("LocateVoices", 2), desire("LocateFaces", 8, 8)], TABLE_4_4, CPU)
    reason = explain(p, solve(p), time_limit_s=60, resources=RESOURCES)["LocateVoices"]
    assert reason.state == "unfulfilled"
    assert reason.text == (
        "unfulfilled: what it needs does not fit beside what is worth more; "
        "would be fulfilled with 20 % more cpu or without LocateFaces"
    )


def test_inhibited_and_what_depends_on_it() -> None:
    p = problem([desire("SLAM", 3, 0), desire("GoTo", 8)], TABLE_4_4, CPU)
    reasons = explain(p, solve(p), time_limit_s=60)
    assert reasons["SLAM"].text == "inhibited by a desire of intensity 3"
    assert reasons["GoTo"].text == (
        "unfulfilled: it depends on SLAM, which is inhibited; would be fulfilled without SLAM"
    )


def test_what_no_resource_can_help() -> None:
    table = (
        Strategy("faces", "LocateFaces", 4),
        Strategy("go", "GoTo", 8, requires={"SLAM": 1}),
    )
    p = problem([desire("LocateFaces", 1, 8), desire("Dance", 1, security=True), desire("GoTo", 1)], table, {})
    selection = solve(p)
    reasons = explain(p, selection, time_limit_s=60)
    assert reasons["LocateFaces"].text == "unfulfilled: it asks for utility 8, its strategies produce at most 4"
    assert reasons["Dance"].text == "unfulfilled: no strategy serves this class, though its security is asked for"
    assert reasons["GoTo"].text == "unfulfilled: it depends on SLAM, which no strategy serves"


def test_without_time_the_states_are_said_all_the_same() -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    reasons = explain(p, solve(p), time_limit_s=0)
    assert {cls: (r.state, r.alternatives) for cls, r in reasons.items()} == {
        "GoTo": ("fulfilled", ()),
        "LocateFaces": ("degraded", ()),
    }


def test_best_utility() -> None:
    table = (
        Strategy("a", "A", 3, filters={"M.x": 1}),
        Strategy("b", "A", 4, filters={"M.x": 2, "M.y": 1}),
        Strategy("c", "A", 2, filters={"M.y": 1}),
        Strategy("d", "A", 1, requires={"B": 1}),
    )
    assert best_utility(problem([desire("A", 1)], table, {}), "A") == 6, "a, c and d exclude each other in no pair"
    assert best_utility(problem([desire("A", 1), desire("B", 1, 0)], table, {}), "A") == 5


@settings(max_examples=60, deadline=None)
@given(problems())
def test_every_alternative_is_true(p: Problem) -> None:
    selection = solve(p)
    reasons = explain(p, selection, time_limit_s=30)
    assert list(reasons) == list(p.desires)
    for cls, reason in reasons.items():
        got = produced(p, selection.strategies, cls) if cls in selection.fulfilled else 0
        assert reason.utility == got
        if reason.state == "fulfilled":
            assert got >= reason.best > 0
        assert (reason.state == "inhibited") is (p.desires[cls].utility == 0)
        assert (reason.state == "unfulfilled") is (cls not in selection.fulfilled and reason.state != "inhibited")
        for alternative in reason.alternatives:
            if alternative.kind == "without":
                changed = p.without(alternative.without)
            else:
                assert alternative.amount > 0
                capacity = round(p.capacities[alternative.resource] + alternative.amount, 3)
                changed = p.with_capacity(alternative.resource, capacity)
            then = solve(changed)
            assert cls in then.fulfilled
            assert math.isclose(produced(changed, then.strategies, cls), alternative.utility)
            assert alternative.utility > got


def test_a_search_given_up_offers_nothing_it_has_not_checked() -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    selection = solve(p)
    assert explain(p, selection, time_limit_s=60, give_up=lambda: True) == explain(p, selection, time_limit_s=0)
