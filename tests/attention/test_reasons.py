"""Reasons: every alternative offered is true, and the texts say what the fields say."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import pytest
from hypothesis import given, settings

from app.attention.prepared import prepare
from app.attention.problem import Selection, SelectionProblem, produced
from app.attention.reasons import explain
from app.attention.solver import solve
from app.attention.strategies import Resource, Strategy, exclusive
from app.attention.utility_bound import best_utility
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
    assert best_utility(prepare(table), "A") == 6, "a, c and d exclude each other in no pair"
    assert best_utility(prepare(table), "A", frozenset({"B"})) == 5
    assert best_utility(prepare(table), "Z") == 0


@settings(max_examples=60, deadline=None)
@given(problems())
def test_every_alternative_is_true(p: SelectionProblem) -> None:
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


@settings(max_examples=60, deadline=None)
@given(problems())
def test_whose_absence_would_help_is_found_as_if_each_had_been_tried(p: SelectionProblem) -> None:
    """Sharing what was solved, and leaving out desires that take nothing from others, loses no alternative."""
    selection = solve(p)
    for cls, reason in explain(p, selection, time_limit_s=30).items():
        assert reason.searched
        offered = {a.without for a in reason.alternatives if a.kind == "without"}
        if reason.state in ("fulfilled", "inhibited") or not offered:
            continue
        least = min(a.utility for a in reason.alternatives if a.kind == "without")
        for other in p.desires:
            then = solve(p.without(other))
            got = produced(p, then.strategies, cls) if cls in then.fulfilled else 0
            assert (other in offered) is (other != cls and got >= least)


@settings(max_examples=100, deadline=None)
@given(problems(most=10))
def test_best_utility_is_that_of_the_best_set_without_resources(p: SelectionProblem) -> None:
    inhibited = frozenset(cls for cls, d in p.desires.items() if d.utility == 0)
    for cls in p.desires:
        able = [s for s in p.strategies if s.cls == cls and inhibited.isdisjoint(s.requires)]
        sets = (chosen for size in range(len(able) + 1) for chosen in combinations(able, size))
        together = (c for c in sets if not any(exclusive(one, other) for one, other in combinations(c, 2)))
        assert best_utility(prepare(p.strategies), cls, inhibited) == max(sum(s.utility for s in c) for c in together)


def test_states_are_said_without_solving_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where a class's strategies exclude each other in no pair, so that the best of it is no plain maximum."""
    table = tuple(Strategy(f"s{n}", "A", 1, costs={"cpu": 30}) for n in range(8))
    p = problem([desire("A", 1)], table, CPU)
    selection = solve(p, time_limit_s=60)

    def never(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr("app.attention.variants.solve", never)
    reason = explain(p, selection, time_limit_s=0)["A"]
    assert (reason.state, reason.utility, reason.best, reason.searched) == ("degraded", 3, 8, False)


def test_no_variant_is_started_that_cannot_end_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    selection = solve(p)
    slow = replace(selection, solve_time_s=1e6)
    solved: list[object] = []

    def counted(*arguments: object, **_: object) -> Selection:
        solved.append(arguments)
        return selection

    monkeypatch.setattr("app.attention.variants.solve", counted)
    reasons = explain(p, slow, time_limit_s=60)
    assert not solved
    assert (reasons["LocateFaces"].alternatives, reasons["LocateFaces"].searched) == ((), False)
    assert reasons["GoTo"].searched, "it is at its best: there is nothing to look for"


def test_many_classes_share_what_was_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve classes of which none has what it could: each other desire is left out once, not once for each."""
    table = tuple(
        Strategy(f"{cls}-{phi}", cls, 8 / phi, filters={f"{cls}.x": phi}, costs={"cpu": 16 / phi})
        for cls in "ABCDEFGHIJKL"
        for phi in (1, 2, 4, 8)
    )
    p = problem([desire(cls, 1 + number % 3) for number, cls in enumerate("ABCDEFGHIJKL")], table, CPU)
    asked: list[SelectionProblem] = []

    def counted(changed: SelectionProblem, **options: Any) -> Selection:
        asked.append(changed)
        return solve(changed, **options)

    monkeypatch.setattr("app.attention.variants.solve", counted)
    reasons = explain(p, solve(p), time_limit_s=600)
    assert all(reason.searched for reason in reasons.values())
    without = [changed for changed in asked if len(changed.desires) < 12]
    assert len(without) <= 12
    assert len({changed.capacities["cpu"] for changed in asked if changed not in without}) + len(without) == len(asked)


def test_a_search_given_up_offers_nothing_it_has_not_checked() -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    selection = solve(p)
    assert explain(p, selection, time_limit_s=60, give_up=lambda: True) == explain(p, selection, time_limit_s=0)


@pytest.mark.parametrize(
    ("most", "offer", "searched"),
    [
        (0, "", False),
        (1, "would get 8 with at most 10 % more cpu", False),
        (100, "would get 8 with 10 % more cpu or without GoTo", True),
    ],
)
def test_an_amount_not_known_to_be_the_least_is_said_to_be_a_bound(most: int, offer: str, searched: bool) -> None:
    """After ``most`` variants the search is given up."""
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    asked = iter(range(10_000))
    reasons = explain(p, solve(p), time_limit_s=60, resources=RESOURCES, give_up=lambda: next(asked) >= most)
    reason = reasons["LocateFaces"]
    assert reason.text.partition("; ")[2] == offer
    assert reason.searched is searched
