"""The compiled search for several graded resources, against CP-SAT and the label search."""

from __future__ import annotations

import random
from dataclasses import replace

import msgspec
import pytest
from hypothesis import assume, given, settings

from app.attention.class_options import list_options
from app.attention.cpsat import solve_cpsat
from app.attention.graded import solve_graded
from app.attention.integer_program import Infeasible, build_integer_program
from app.attention.problem import SelectionProblem, Weights
from app.attention.search import solve_search
from app.attention.strategies import Strategy
from tests.attention.test_solver import problems
from tests.attention.thesis import desire, problem


def graded(p: SelectionProblem) -> tuple[tuple[int, ...], int] | None:
    """What the search chooses, and Ω's bound; None where the security desires cannot be met."""
    instance = build_integer_program(p)
    try:
        choice = list_options(instance)
        assert choice is not None
        assert choice.capacities, "nothing is contended for"
        answer = solve_graded(instance, choice, float("inf"))
    except Infeasible:
        return None
    assert answer is not None
    assert answer.proven
    return answer.chosen, answer.bound


@settings(max_examples=150, deadline=None)
@given(problems(most=12))
def test_selects_as_the_label_search(p: SelectionProblem) -> None:
    try:
        choice = list_options(build_integer_program(p))
        assume(choice is not None and choice.capacities)
        answer = solve_search(build_integer_program(p), float("inf"))
    except Infeasible:
        answer = None
    if answer is None:
        assert graded(p) is None
        return
    ours = graded(p)
    assume(answer.proven)
    assert ours == (answer.chosen, answer.bound)


def contending(seed: int) -> SelectionProblem:
    """Up to ten classes contending for up to four resources, with dependencies, inhibition, security and ties."""
    chance = random.Random(seed)
    names = [f"r{j}" for j in range(chance.randint(2, 4))]
    classes = chance.randint(4, 10)
    table = []
    for k in range(classes):
        wants = {name: chance.randint(1, 6) for name in names}
        needs = {f"K{(k + 1) % classes}": chance.choice([0.5, 1, 3])} if chance.random() < 0.2 else {}
        table += [
            Strategy(
                f"k{k}-{phi}",
                f"K{k}",
                8 / phi,
                requires=needs,
                filters={f"K{k}.{phi if chance.random() < 0.1 else 'x'}": phi},
                costs={name: round(want / phi, 3) for name, want in wants.items()},
            )
            for phi in (1, 2, 4)
        ]
    desires = [
        desire(f"K{k}", chance.randint(1, 4), chance.choice([0, 1, 1, 2]), security=chance.random() < 0.1)
        for k in range(classes)
    ]
    kept = [s.name for s in table if chance.random() < 0.2]
    p = problem(desires, tuple(table), {name: float(chance.randint(3, classes + 4)) for name in names}, kept)
    return replace(p, weights=Weights(1, 1, chance.choice([0, 0.05]), spare_of="r0"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_selects_as_cp_sat_where_many_are_equal(seed: int) -> None:
    p = contending(seed)
    ours = graded(p)
    try:
        answer = solve_cpsat(build_integer_program(p), float("inf"))
    except Infeasible:
        assert ours is None
        return
    assert answer is not None
    assert ours == (tuple(sorted(answer.chosen)), answer.bound)


def test_equal_classes_are_decided_by_the_order_of_the_table() -> None:
    """Eight classes of which three fit: 56 selections are equal in all but the table's order."""
    table = tuple(Strategy(cls, cls, 8, costs={"a": 2, "b": 3}) for cls in "ABCDEFGH")
    p = problem([desire(cls, 8) for cls in "ABCDEFGH"], table, {"a": 7, "b": 9})
    assert graded(p) is not None
    assert graded(p) == ((0, 1, 2), 48_000_000)


def test_more_equal_selections_than_are_looked_at_one_by_one() -> None:
    table = tuple(Strategy(f"s{k:02d}", f"K{k:02d}", 8, costs={"a": 2, "b": 3}) for k in range(14))
    p = problem([desire(s.cls, 8) for s in table], table, {"a": 13, "b": 19})
    assert graded(p) == ((0, 1, 2, 3, 4, 5), 96_000_000)


def test_without_time_what_was_known_stays_with_its_bound() -> None:
    p = contending(1)
    p = replace(p, desires={cls: msgspec.structs.replace(d, security=False) for cls, d in p.desires.items()})
    instance = build_integer_program(p)
    choice = list_options(instance)
    assert choice is not None
    known = solve_search(instance, float("inf"))
    assert known is not None
    answer = solve_graded(instance, choice, float("-inf"), known)
    assert answer is not None
    assert answer.chosen == known.chosen
    assert not answer.proven
    best = solve_cpsat(instance, float("inf"))
    assert best is not None
    assert best.bound <= answer.bound <= known.bound


@pytest.mark.parametrize("seed", [6, 8])
def test_what_is_no_better_is_not_looked_for(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """200 strategies for half of each of four resources: once the best is found, little is left to look at. Counted in
    steps; that any fraction of a loss less was looked for took over a hundred times as many."""
    monkeypatch.setattr("app.attention.graded._MOST_STEPS", 3_000_000)
    chance = random.Random(seed)
    full = dict.fromkeys(("r0", "r1", "r2", "r3"), 0.0)
    table: list[Strategy] = []
    for k in range(50):
        wants = {name: chance.uniform(5, 40) for name in full}
        full = {name: amount + wants[name] for name, amount in full.items()}
        for phi in (1, 2, 4, 8):
            costs = {name: round(amount / phi, 3) for name, amount in wants.items()}
            table.append(Strategy(f"K{k}-{phi}", f"K{k}", 8 / phi, filters={f"K{k}.x": phi}, costs=costs))
    capacities = {name: round(amount / 2, 3) for name, amount in full.items()}
    desires = [desire(f"K{k}", chance.randint(1, 8)) for k in range(50)]
    assert graded(problem(desires, tuple(table), capacities)) is not None
