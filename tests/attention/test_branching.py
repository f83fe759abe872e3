"""The search of small problems: the same selection as exhaustion and as the searches of larger ones."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.attention.branching import solve_small
from app.attention.integer_program import Infeasible, build_integer_program
from app.attention.prepared import InvalidProblem
from app.attention.problem import SelectionProblem, Weights
from app.attention.search import solve_search
from app.attention.solver import solve
from app.attention.strategies import Strategy
from tests.attention.test_solver import problems
from tests.attention.thesis import CPU, TABLE_4_4, desire, exhaust, problem

weights = st.sampled_from([Weights(), Weights(2, 0.5), Weights(1, 1, 0.25), Weights(1, 1, 1.5, spare_of="arm")])


@settings(max_examples=300, deadline=None)
@given(problems(most=10), weights)
def test_equals_the_search_of_larger_problems(p: SelectionProblem, weights: Weights) -> None:
    p = replace(p, weights=weights).with_table()
    try:
        small = solve_small(p)
        assume(small is not None)
    except Infeasible:
        small = None
    instance = build_integer_program(p)
    try:
        answer = solve_search(instance, float("inf"))
    except Infeasible:
        assert small is None
        return
    assume(answer is not None)
    assert answer is not None
    assert small == tuple(instance.table[s] for s in answer.chosen)


@settings(max_examples=60, deadline=None)
@given(problems(security=False, most=7))
def test_equals_exhaustion(p: SelectionProblem) -> None:
    chosen = solve_small(p.with_table())
    assume(chosen is not None)
    assert chosen is not None
    found = exhaust(p)
    assert found is not None
    assert tuple(p.strategies[index].name for index in chosen) == found.strategies


def test_the_thesis_s_table_is_small() -> None:
    p = problem([desire(cls, 8) for cls in dict.fromkeys(s.cls for s in TABLE_4_4)], TABLE_4_4, CPU).with_table()
    chosen = solve_small(p)
    assert chosen is not None
    assert {p.strategies[index].name for index in chosen} == {"3", "6", "9", "11", "12", "13"}


def test_a_problem_of_many_combinations_is_left_to_others() -> None:
    table = tuple(
        Strategy(f"{cls}-{phi}", cls, 8 / phi, filters={f"{cls}.x": phi}, costs={"cpu": 16 / phi})
        for cls in "ABCDEFGHIJKL"
        for phi in (1, 2, 4, 8)
    )
    p = problem([desire(cls, 8) for cls in "ABCDEFGHIJKL"], table, CPU).with_table()
    assert solve_small(p) is None
    assert solve(p).proven


def test_security_without_a_strategy_is_infeasible_until_it_is_relaxed() -> None:
    p = problem([desire("Dance", 8, security=True), desire("SLAM", 8)], TABLE_4_4, CPU).with_table()
    with pytest.raises(Infeasible):
        solve_small(p)
    assert solve_small(p, frozenset({"Dance"})) == (10,)


def test_a_capacity_is_checked() -> None:
    with pytest.raises(InvalidProblem, match="the capacity of cpu"):
        solve_small(problem([desire("SLAM", 8)], TABLE_4_4, {"cpu": float("nan")}).with_table())
