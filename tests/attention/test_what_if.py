"""What attention would choose: as the optimum of the supposed problem is, and nothing else is changed."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.attention.desires import InvalidDesire
from app.attention.problem import SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import Resource
from app.attention.what_if import Supposition, UnknownNames, intention_if, supposed
from app.messages import Asked
from tests.attention.test_solver import problems
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem

RESOURCES = {"cpu": Resource("cpu", 100, "% of one core")}
CONTROLLED = frozenset(name for strategy in TABLE_4_4 for name in strategy.filters)
NOW = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)


def ask(supposition: Supposition, of: SelectionProblem = NOW, **limits: Any) -> Any:
    limits = {"time_limit_s": 60, "explain_limit_s": 60, **limits}
    return intention_if(of, supposition, 5.0, controlled=CONTROLLED, resources=RESOURCES, **limits)


def test_a_greater_budget_gives_what_the_reason_promised() -> None:
    before = ask(Supposition())
    assert before.reasons["LocateFaces"].text.endswith("would get 8 with 10 % more cpu or without GoTo")
    after = ask(Supposition(capacities={"cpu": 110.0}))
    assert after.reasons["LocateFaces"].state == "fulfilled"
    assert after.divisors["FaceDetector.images"] == 1
    assert after.capacities == {"cpu": 110}
    assert ask(Supposition(desires={"GoTo": None})).reasons.keys() == {"LocateFaces"}


def test_a_cheaper_strategy_is_chosen_and_a_new_desire_is_served() -> None:
    cheap = ask(Supposition(costs={"5": {"cpu": 50.0}}))
    assert cheap.selection.strategies == ("5", "11", "13")
    assert cheap.selection.use == {"cpu": 100}
    noises = ask(Supposition(desires={"DetectNoises": Asked(3, 1, security=False)}))
    assert noises.divisors["LoudNoiseDetector.audio"] == 1
    assert noises.desires["DetectNoises"].id == ""
    inhibited = ask(Supposition(desires={"LocateFaces": Asked(8, 0, security=False)}))
    assert inhibited.divisors["FaceDetector.images"] == math.inf
    assert inhibited.reasons["LocateFaces"].state == "inhibited"


def test_a_supposed_desire_keeps_the_parameters_of_the_one_there_is() -> None:
    changed = supposed(NOW, Supposition(desires={"GoTo": Asked(2.0005, 1, security=True)}), 5.0)
    goal = changed.desires["GoTo"]
    assert (goal.id, goal.params, goal.security) == ("d-GoTo", NOW.desires["GoTo"].params, True)
    assert changed.desires["LocateFaces"] is NOW.desires["LocateFaces"]


def test_what_there_is_not_is_refused_by_name() -> None:
    wrong = Supposition(costs={"5": {"gold": 1.0}, "99": {}}, capacities={"gold": 1.0})
    with pytest.raises(UnknownNames) as refused:
        supposed(NOW, wrong, 5.0)
    assert refused.value.names == ("costs.99", "costs.5.gold", "capacities.gold")
    with pytest.raises(InvalidDesire):
        supposed(NOW, Supposition(desires={"GoTo": Asked(9, 1, security=False)}), 5.0)


@given(problems(), st.floats(0, 200), st.data())
@settings(max_examples=60)
def test_it_is_the_optimum_of_the_changed_problem(p: SelectionProblem, budget: float, data: st.DataObject) -> None:
    cls = data.draw(st.sampled_from(sorted({s.cls for s in p.strategies})))
    strategy = data.draw(st.sampled_from([s.name for s in p.strategies]))
    resource = data.draw(st.sampled_from(sorted(p.capacities)))
    controlled = {name for s in p.strategies for name in s.filters}
    before = repr(p)
    supposition = Supposition(
        {cls: data.draw(st.sampled_from([None, Asked(5, 2, security=False)]))},
        {strategy: {resource: budget / 3}},
        {resource: budget},
    )
    found = intention_if(
        p, supposition, 0.0, controlled=controlled, resources={}, time_limit_s=60, explain_limit_s=0
    ).selection
    again = solve(supposed(p, supposition, 0.0), time_limit_s=60)
    assert (found.strategies, found.omega) == (again.strategies, again.omega)
    assert repr(p) == before
    assert all(found.use[name] <= capacity for name, capacity in {**p.capacities, resource: budget}.items())
