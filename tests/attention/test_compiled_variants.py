"""The compiled variants against exhaustive search, CP-SAT and HiGHS."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from app.attention.compiled_variants import CompiledProblem, compile_problem
from app.attention.cpsat import solve_cpsat
from app.attention.desires import GRAIN
from app.attention.graded_kernels import prices
from app.attention.integer_program import build_integer_program
from app.attention.problem import SelectionProblem, assess, produced
from app.attention.solver import solve
from app.attention.strategies import Strategy
from tests.attention.test_graded import contending
from tests.attention.thesis import CPU, desire, exhaust, problem

FOREVER = float("inf")


@st.composite
def contended(draw: st.DrawFn) -> SelectionProblem:
    """Up to seven strategies of three classes for too little of two resources, with dependencies, inhibition, security
    and equal strategies."""
    chance = random.Random(draw(st.integers(0, 2**32 - 1)))
    table = []
    for number in range(chance.randint(4, 7)):
        cls = chance.choice("ABC")
        needs = {chance.choice([c for c in "ABCD" if c != cls]): chance.choice([0.5, 1, 2])}
        table.append(
            Strategy(
                f"s{number}",
                cls,
                chance.choice([0.5, 1, 2, 4]),
                requires=needs if chance.random() < 0.2 else {},
                filters={f"{cls}.{chance.choice('xxy')}": 1} if chance.random() < 0.8 else {},
                costs={name: chance.choice([0, 1, 1, 2, 3.5]) for name in ("cpu", "arm")},
            )
        )
    desires = [
        desire(cls, chance.choice([0.5, 1, 1, 2]), chance.choice([0, 0.5, 1, 1]), security=chance.random() < 0.1)
        for cls in "ABC"
    ]
    kept = [s.name for s in table if chance.random() < 0.2]
    return problem(desires, tuple(table), {"cpu": chance.choice([1, 2, 3, 4]), "arm": chance.choice([1, 2, 3])}, kept)


def compiled(p: SelectionProblem) -> CompiledProblem:
    """``p`` as the compiled search has it; an example where nothing is contended for does not count."""
    assume(not solve(p).relaxed)
    found = compile_problem(p, FOREVER)
    assume(found is not None and found.row)
    assert found is not None
    return found


def by_exhaustion(p: SelectionProblem) -> tuple[dict[str, int], tuple[str, ...]]:
    """The utility of each class that is fulfilled, in thousandths, and what is selected."""
    found = exhaust(p)
    assert found is not None
    got = {cls: round(produced(p, found.strategies, cls) * GRAIN) for cls in found.fulfilled}
    return got, found.strategies


def positive(got: dict[str, int]) -> dict[str, int]:
    return {cls: utility for cls, utility in got.items() if utility}


@settings(max_examples=120, deadline=None)
@given(contended(), st.data())
def test_with_more_of_a_resource_it_is_the_optimum_of_exhaustive_search(
    p: SelectionProblem, data: st.DataObject
) -> None:
    model = compiled(p)
    resource = data.draw(st.sampled_from(sorted(model.row)))
    capacity = round(p.capacities[resource] + data.draw(st.sampled_from([0, 0.25, 0.6, 1, 2.25, 3.5, 9])), 3)
    found = model.under(resource, round(capacity * GRAIN), FOREVER)
    assert found is not None
    got, names = by_exhaustion(p.with_capacity(resource, capacity))
    assert positive(found[0]) == got
    assert found[1] == round(sum(s.costs.get(resource, 0) for s in p.strategies if s.name in names) * GRAIN)


@settings(max_examples=120, deadline=None)
@given(contended())
def test_without_a_desire_it_is_the_optimum_of_exhaustive_search(p: SelectionProblem) -> None:
    model = compiled(p)
    for cls, wanted in p.desires.items():
        if wanted.utility and cls in model.number:
            found = model.without(cls, FOREVER)
            assert found is not None
            assert positive(found) == by_exhaustion(p.without(cls))[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_variants_are_those_of_cp_sat_where_many_contend(seed: int) -> None:
    p = contending(seed)
    if solve(p).relaxed:
        return
    model = compile_problem(p, FOREVER)
    assert model is not None

    def check(changed: SelectionProblem, got: dict[str, int] | None) -> None:
        assert got is not None
        instance = build_integer_program(changed)
        answer = solve_cpsat(instance, FOREVER)
        assert answer is not None
        selection = assess(changed, [changed.strategies[instance.table[s]].name for s in answer.chosen])
        assert selection is not None
        assert positive(got) == {
            cls: round(produced(changed, selection.strategies, cls) * GRAIN) for cls in selection.fulfilled
        }

    for resource in model.row:
        for more in (1.1, 1.37):
            capacity = round(p.capacities[resource] * more, 3)
            found = model.under(resource, round(capacity * GRAIN), FOREVER)
            check(p.with_capacity(resource, capacity), found and found[0])
    for cls, wanted in p.desires.items():
        if wanted.utility and cls in model.number:
            check(p.without(cls), model.without(cls, FOREVER))


def test_what_costs_more_than_there_is_comes_in_with_more() -> None:
    table = (Strategy("big", "A", 8, costs={"cpu": 130}), Strategy("small", "A", 1, costs={"cpu": 90}))
    p = problem([desire("A", 8), desire("B", 1)], (*table, Strategy("b", "B", 1, costs={"cpu": 20})), CPU)
    model = compile_problem(p, FOREVER)
    assert model is not None
    assert model.under("cpu", 129_000, FOREVER) == ({"A": 1000, "B": 1000}, 110_000)
    assert model.under("cpu", 149_000, FOREVER) == ({"A": 8000, "B": 0}, 130_000)
    assert model.under("cpu", 150_000, FOREVER) == ({"A": 8000, "B": 1000}, 150_000)


def test_without_time_there_is_no_answer() -> None:
    model = compile_problem(contending(1), FOREVER)
    assert model is not None
    assert model.under(next(iter(model.row)), 10**6, float("-inf")) is None
    assert compile_problem(contending(1), float("-inf")) is None


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_prices_are_those_of_the_linear_relaxation(seed: int) -> None:
    """By strong duality: the bound that they give is the optimum that HiGHS finds."""
    chance = np.random.default_rng(seed)
    classes, width = int(chance.integers(1, 30)), int(chance.integers(1, 7))
    sizes = chance.integers(1, 6, classes)
    starts = np.array([0, *np.cumsum(sizes)], dtype=np.int64)
    losses = chance.integers(0, 50, starts[-1]).astype(float)
    losses -= np.repeat(np.minimum.reduceat(losses, starts[:-1]), sizes)
    costs = chance.integers(-3, 20, (width, starts[-1])).astype(float)
    room = np.round(costs.sum(axis=1) / sizes.mean() * chance.uniform(0.3, 1.1))
    one_each = np.zeros((classes, starts[-1]))
    one_each[np.repeat(np.arange(classes), sizes), np.arange(starts[-1])] = 1
    answer = linprog(losses, A_ub=costs, b_ub=room, A_eq=one_each, b_eq=np.ones(classes), method="highs-ds")
    found, status = prices(starts, losses / 50, costs / 20, room / 20, 5000)
    assert status == (1 if answer.status == 2 else 0)
    if status == 0:
        price = found * 50 / 20
        assert price.min() >= -1e-9
        bound = np.minimum.reduceat(losses + price @ costs, starts[:-1]).sum() - price @ room
        assert bound == pytest.approx(answer.fun, abs=1e-6)


def test_a_dependency_that_security_always_fills_binds_once_that_desire_is_gone() -> None:
    table = (
        Strategy("a", "A", 4, requires={"C": 1}, costs={"cpu": 10}),
        Strategy("c", "C", 2, costs={"cpu": 95}),
        Strategy("b", "B", 1, costs={"cpu": 60}),
    )
    p = problem([desire("A", 1), desire("B", 8), desire("C", 1, security=True)], table, CPU)
    model = compile_problem(p, FOREVER)
    assert model is not None
    found = model.without("C", FOREVER)
    assert found is not None
    assert positive(found) == by_exhaustion(p.without("C"))[0] == {"B": 1000}
