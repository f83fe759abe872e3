"""How solving is shared between the label search and CP-SAT, and what time and size do to it."""

from __future__ import annotations

import random
import sys
import threading
import time
from dataclasses import replace
from typing import Any

import pytest

from app.attention.class_options import ClassOptions, list_options
from app.attention.cpsat import solve_cpsat
from app.attention.graded import solve_graded
from app.attention.integer_program import Infeasible, IntegerProgram, build_integer_program
from app.attention.prepared import prepare
from app.attention.problem import SelectionProblem
from app.attention.search import solve_search
from app.attention.solver import CPSAT, GRADED, SolverFailed, foreseen, load, solve
from app.attention.strategies import Strategy
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem


def many_resources(classes: int, resources: int, seed: int) -> SelectionProblem:
    """Classes of four strategies that contend for half of each of several graded resources."""
    chance = random.Random(seed)
    full = {f"r{j}": 0.0 for j in range(resources)}
    table = []
    for k in range(classes):
        costs = {name: chance.uniform(5, 40) for name in full}
        for name, cost in costs.items():
            full[name] += cost
        table += [
            Strategy(
                f"k{k}-{phi}",
                f"K{k}",
                8 / phi,
                filters={f"K{k}.x": phi},
                costs={name: round(cost / phi, 3) for name, cost in costs.items()},
            )
            for phi in (1, 2, 4, 8)
        ]
    desires = [desire(f"K{k}", chance.randint(1, 8)) for k in range(classes)]
    return problem(desires, tuple(table), {name: round(amount / 2, 3) for name, amount in full.items()})


def options_of(p: SelectionProblem) -> ClassOptions:
    choice = list_options(build_integer_program(p))
    assert choice is not None
    return choice


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_where_several_graded_resources_contend_the_compiled_search_selects_as_cp_sat(seed: int) -> None:
    p = many_resources(13, 3, 2 * seed)
    instance = build_integer_program(p)
    left = solve_search(instance, float("inf"))
    assert left is not None
    assert not left.proven
    alone = solve_cpsat(instance, float("inf"))
    assert alone is not None
    selection = solve(p, time_limit_s=600)
    assert selection.proven
    assert set(selection.strategies) == {p.strategies[instance.table[s]].name for s in alone.chosen}


@pytest.mark.slow
def test_cp_sat_proves_what_the_compiled_search_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    p = many_resources(13, 3, 0)
    expected = solve(p, time_limit_s=600)
    monkeypatch.setattr("app.attention.graded._MOST_STEPS", 10)
    left = solve_graded(build_integer_program(p), options_of(p), float("inf"))
    assert left is None or not left.proven
    selection = solve(p, time_limit_s=600)
    assert selection.proven
    assert selection.strategies == expected.strategies


def test_where_one_graded_resource_contends_the_search_goes_on_to_the_proof() -> None:
    answer = solve_search(build_integer_program(many_resources(50, 1, 0)), float("inf"))
    assert answer is not None
    assert answer.proven


def test_late_is_as_good_as_never_where_the_limit_is_firm() -> None:
    p = many_resources(13, 3, 0)
    assert not solve(p, time_limit_s=0).proven, "the best found at once"
    with pytest.raises(SolverFailed, match="no selection was found within 0 s"):
        solve(p, time_limit_s=0, firm=True)


def test_which_securities_fit_is_never_guessed_when_the_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    table = tuple(Strategy(cls, cls, 8, costs={"cpu": 60}) for cls in "AB")
    p = problem([desire("A", 4, security=True), desire("B", 5, security=True)], table, CPU)
    assert solve(p).relaxed == ("A",)

    def too_late(instance: IntegerProgram, deadline: float, **_: Any) -> None:
        if len(instance.security) == 2:
            raise Infeasible

    monkeypatch.setattr("app.attention.solver.solve_small", lambda *_: None)
    monkeypatch.setattr("app.attention.solver.solve_search", too_late)
    with pytest.raises(SolverFailed, match="which security desires can be kept"):
        solve(p, time_limit_s=0)


@pytest.mark.parametrize("name", [CPSAT, GRADED])
def test_a_search_is_waited_for_no_longer_than_there_is_time(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert load(name, time.perf_counter()) is None
    assert load(name) is sys.modules[name]
    go_on = threading.Event()
    monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr("app.attention.solver._import", lambda _: go_on.wait())
    try:
        assert load(name, time.perf_counter() + 0.001) is None
    finally:
        go_on.set()


def test_which_searches_will_be_needed_is_foreseen() -> None:
    free = (Strategy("a", "Free", 1), Strategy("b", "Free", 1))
    assert foreseen(prepare(TABLE_4_4)) == ()
    assert foreseen(prepare((*TABLE_4_4, *free))) == (CPSAT,)
    assert foreseen(prepare(many_resources(2, 2, 0).strategies)) == (GRADED, CPSAT)


def test_ten_thousand_strategies_of_one_class_take_no_ten_thousand_squared() -> None:
    """As much time as the strategies have pairs would be minutes; the test's own time limit sees that."""
    table = tuple(Strategy(f"s{n}", "A", 1 + n % 7, filters={"M.x": n + 1}, costs={"cpu": n}) for n in range(10_000))
    selection = solve(problem([desire("A", 8)], table, {"cpu": 5}), time_limit_s=600)
    assert selection.strategies == ("s5",)
    assert selection.proven


def test_a_table_prepared_for_other_strategies_is_not_used() -> None:
    p = problem([desire("GoTo", 8)], TABLE_4_4, CPU).with_table()
    assert p.table is p.prepared
    other = replace(p, strategies=TABLE_4_4[1:])
    assert other.table is not p.prepared
    assert build_integer_program(p) == replace(build_integer_program(replace(p, prepared=None)), problem=p)
