"""How solving is shared between the label search and CP-SAT, and what time and size do to it."""

from __future__ import annotations

import random
import sys
import threading
import time
from dataclasses import replace
from typing import Any

import pytest

from app.attention.cpsat import solve_cpsat
from app.attention.integer_program import Infeasible, IntegerProgram, build_integer_program
from app.attention.prepared import prepare
from app.attention.problem import SelectionProblem
from app.attention.search import solve_search
from app.attention.solver import SolverFailed, foresees_cpsat, load_cpsat, solve
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


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_where_several_graded_resources_contend_cp_sat_proves_what_the_search_leaves(seed: int) -> None:
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


def test_cp_sat_is_waited_for_no_longer_than_there_is_time(monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_cpsat(time.perf_counter()) is None
    assert load_cpsat() is solve_cpsat
    go_on = threading.Event()
    monkeypatch.delitem(sys.modules, "app.attention.cpsat")
    monkeypatch.setattr("app.attention.solver._import_cpsat", go_on.wait)
    try:
        assert load_cpsat(time.perf_counter() + 0.001) is None
    finally:
        go_on.set()


@pytest.mark.parametrize(("table", "foreseen"), [(TABLE_4_4, False), (many_resources(2, 2, 0).strategies, True)])
def test_where_cp_sat_will_be_needed_is_foreseen(table: tuple[Strategy, ...], foreseen: bool) -> None:
    assert foresees_cpsat(prepare(table)) is foreseen
    assert foresees_cpsat(prepare((*table, Strategy("a", "Free", 1), Strategy("b", "Free", 1))))


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
