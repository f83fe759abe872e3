"""Certificates: what the solver proves is certified; what is tampered with is refused."""

from __future__ import annotations

import ast
import json
import math
import tokenize
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.attention.problem import SelectionProblem, Weights, assess
from app.attention.proof import checker
from app.attention.proof.certificate import HEAD, certify
from app.attention.proof.checker import check
from app.attention.proof.equations import Refused
from app.attention.proof.prover import NotProven
from app.attention.proof.statement import claim_of
from app.attention.solver import solve
from app.attention.strategies import Strategy
from tests.attention.test_graded import contending
from tests.attention.test_solver import problems
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem

ALL_SEVEN = problem([desire(cls, 8) for cls in dict.fromkeys(s.cls for s in TABLE_4_4)], TABLE_4_4, CPU)
"""Tableau 4.4 with all seven classes desired: Ω is 86."""


def certificate(p: SelectionProblem) -> dict[str, Any]:
    return json.loads(certify(claim_of(p, solve(p))))


def refused(stated: dict[str, Any]) -> bool:
    try:
        check(json.dumps(stated))
    except Refused:
        return True
    return False


@settings(max_examples=100, deadline=None)
@given(problems(most=9), st.sampled_from([Weights(), Weights(0.5, 2, 0.01), Weights(spare=0.25, spare_of="arm")]))
def test_what_is_proven_is_certified(p: SelectionProblem, weights: Weights) -> None:
    """Dependencies, inhibition, security that is relaxed, several strategies of a class, ties, weights."""
    p = replace(p, weights=weights)
    selection = solve(p)
    assume(selection.proven)
    assert check(certify(claim_of(p, selection))) == round(selection.omega * 1e6)


@pytest.mark.parametrize("seed", range(12))
def test_what_is_contended_for_by_many_is_certified(seed: int) -> None:
    p = contending(seed)
    selection = solve(p)
    assert check(certify(claim_of(p, selection))) == round(selection.omega * 1e6)


@settings(max_examples=40, deadline=None)
@given(problems(most=6), st.data())
def test_a_worse_selection_has_no_certificate(p: SelectionProblem, data: st.DataObject) -> None:
    """Any other selection that breaks no constraint, with the proof of the best."""
    best, names = solve(p), [s.name for s in p.strategies]
    sets = [chosen for size in range(len(names) + 1) for chosen in combinations(names, size)]
    possible = [found for chosen in sets if (found := assess(p, chosen, relaxed=best.relaxed)) is not None]
    others = [found for found in possible if set(found.strategies) != set(best.strategies)]
    if not others:
        return  # the best is the only one there is
    other = data.draw(st.sampled_from(others))
    with pytest.raises(NotProven):
        certify(claim_of(p, other))
    stated = certificate(p)
    assert refused({**stated, "selected": other.strategies, "fulfilled": other.fulfilled})


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 11), st.data())
def test_a_proof_that_is_tampered_with_is_refused(seed: int, data: st.DataObject) -> None:
    """A leaf dropped or added, a branch cut, a price that is left out, negative or no number."""
    stated = certificate(contending(seed))
    row = data.draw(st.sampled_from([row for row, tree in stated["trees"].items() if len(tree) > 1] or ["criterion 0"]))
    tree = stated["trees"][row]
    at = data.draw(st.integers(0, len(tree) - 1))
    assert refused({**stated, "trees": {**stated["trees"], row: tree[:at] + tree[at + 1 :]}}), "an entry is dropped"
    assert refused({**stated, "trees": {**stated["trees"], row: [*tree, tree[-1]]}}), "a leaf is added"
    assert refused({**stated, "trees": {other: t for other, t in stated["trees"].items() if other != row}})
    first = next(number for number in tree if isinstance(number, int))
    if len(tree) > 1:
        assert refused({**stated, "trees": {**stated["trees"], row: [first]}}), "branches are cut"
    assert refused({**stated, "prices": [{} for _ in stated["prices"]]})
    assert refused({**stated, "prices": [{name: -n for name, n in of.items()} for of in stated["prices"]]})
    assert refused({**stated, "prices": [*stated["prices"], {"resource r0": math.nan}]})


def test_the_thesis_table_is_certified() -> None:
    """Golden: the certificate in the file is of this problem, whatever prices are found today."""
    stated = certificate(ALL_SEVEN)
    assert stated["selected"] == ["3", "6", "9", "11", "12", "13"]
    assert check(json.dumps(stated)) == 86_000_000
    golden = json.loads((Path(__file__).parent / "tableau-4.4.json").read_text(encoding="utf-8"))
    assert check(json.dumps(golden)) == 86_000_000
    assert golden["problem"] == stated["problem"]
    assert golden["selected"] == stated["selected"]


def test_the_golden_certificate_is_refused_for_another_problem() -> None:
    golden = json.loads((Path(__file__).parent / "tableau-4.4.json").read_text(encoding="utf-8"))
    for capacity in (99_000, 110_000):
        assert refused({**golden, "problem": {**golden["problem"], "capacities": {"cpu": capacity}}})


def test_security_that_was_given_up_though_it_could_be_kept_is_refused() -> None:
    table = (Strategy("a", "A", 4, costs={"cpu": 60}), Strategy("b", "B", 4, costs={"cpu": 60}))
    p = problem([desire("A", 2, security=True), desire("B", 1, security=True)], table, CPU)
    stated = certificate(p)
    assert stated["relaxed"] == ["B"]
    assert check(json.dumps(stated))
    assert refused({**stated, "relaxed": ["A", "B"]})
    assert refused({**stated, "relaxed": ["A"], "selected": ["b"], "fulfilled": ["B"]})


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "not whole"),
        ("[]", "not whole"),
        ('{"certificate": 1}', "not whole"),
        ('{"certificate": 1, "problem": 0.5}', "not whole"),
        ("[" * 100_000, "not whole"),
    ],
)
def test_what_is_no_certificate_is_refused(text: str, why: str) -> None:
    with pytest.raises(Refused, match=why):
        check(text)


def test_fractions_and_infinity_are_no_amounts() -> None:
    text = json.dumps(certificate(ALL_SEVEN))
    for wrong in ('"cpu": 100000.5', '"cpu": Infinity', '"cpu": NaN', '"cpu": "100000"'):
        with pytest.raises(Refused):
            check(text.replace('"cpu": 100000', wrong))


def test_a_class_with_too_many_choices_is_refused() -> None:
    table = tuple(Strategy(f"s{n}", "A", 0.5, costs={"cpu": 10}) for n in range(13))
    p = problem([desire("A", 8)], table, CPU)
    with pytest.raises(NotProven, match="class A has more than 4096 choices"):
        certify(claim_of(p, solve(p)))


def test_a_certificate_has_a_limit() -> None:
    p = contending(3)
    with pytest.raises(NotProven, match="more branches"):
        certify(claim_of(p, solve(p)), most_leaves=1)
    with pytest.raises(NotProven, match="time"):
        certify(claim_of(p, solve(p)), time_limit_s=0)


def test_a_certificate_is_known_by_its_head() -> None:
    assert certify(claim_of(ALL_SEVEN, solve(ALL_SEVEN))).startswith(HEAD)


def test_the_checker_is_small_and_alone() -> None:
    """At most 60 lines of code, and nothing of the solver."""
    for name, most in (("checker.py", 60), ("equations.py", 60)):
        file = Path(checker.__file__).with_name(name)
        text = file.read_text(encoding="utf-8")
        tree = ast.parse(text)
        said = {
            line
            for node in ast.walk(tree)
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
        }
        blank = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
        with file.open("rb") as source:
            code = {t.start[0] for t in tokenize.tokenize(source.readline) if t.type not in blank}
        assert len(code - said - {0}) <= most
        imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
        assert {module for module in imported if module.startswith("app.")} <= {"app.attention.proof.equations"}
