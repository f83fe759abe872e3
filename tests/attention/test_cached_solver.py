from __future__ import annotations

from typing import Any

import pytest

from app.attention.cached_solver import CachedSolver
from app.attention.desires import Desire, Source
from app.attention.problem import Selection, SelectionProblem
from app.attention.solver import CPSAT, solve
from tests.attention.test_solver import FACES, GOTO, SLAM
from tests.attention.thesis import CPU, desire, problem


def test_cache_answers_equal_problems() -> None:
    solver = CachedSolver(size=2)
    p = problem([desire("GoTo", 8)], (SLAM, GOTO), CPU)
    first = solver.solve(p)
    later = Desire("d-other", "GoTo", 8, 1, False, {"x": 3}, Source("rest", "curl"), 99.0)
    assert solver.solve(problem([later], p.strategies, CPU)) is first
    assert solver.solve(problem([later], p.strategies, {"cpu": 40})).strategies == ()
    statistics = solver.statistics()
    assert (statistics.hits, statistics.misses, statistics.size) == (1, 2, 2)
    assert solver.solve(problem([later], (SLAM, GOTO, *FACES), CPU)).strategies == ("slam", "go-to"), "another table"


def test_an_untimed_cache_reports_no_times() -> None:
    solver = CachedSolver(timed=False)
    p = problem([desire("GoTo", 8)], (SLAM, GOTO), CPU)
    first = solver.solve(p)
    assert first.solve_time_s == 0.0
    assert solver.recall(p) is first
    assert first.strategies == solve(p).strategies


def test_answers_come_with_their_reasons() -> None:
    solver = CachedSolver()
    p = problem([desire("GoTo", 8)], (SLAM, GOTO), CPU)
    assert solver.solve(p).reasons["GoTo"].text == "fulfilled at its best (8) by go-to"
    assert solver.recall(p) is solver.solve(p)
    among = solver.among(p, ["slam"])
    assert (among.strategies, among.reasons["GoTo"].state) == ((), "unfulfilled")
    assert solver.recall(p) is not None, "what was asked beside it is not forgotten"


def test_all_that_is_asked_has_the_limit_it_was_given(monkeypatch: pytest.MonkeyPatch) -> None:
    limits: list[float] = []

    def noted(changed: SelectionProblem, *, time_limit_s: float) -> Selection:
        limits.append(time_limit_s)
        return solve(changed)

    monkeypatch.setattr("app.attention.cached_solver.solve", noted)
    solver = CachedSolver(time_limit_s=0.125)
    p = problem([desire("GoTo", 8)], (SLAM, GOTO), CPU)
    solver.solve(p)
    solver.among(p, ["slam", "go-to"])
    assert limits == [0.125, 0.125]


def test_only_what_will_be_needed_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded: list[Any] = []
    monkeypatch.setattr("app.attention.cached_solver.load", loaded.append)
    CachedSolver().prepare(problem([], (SLAM, GOTO), CPU))
    assert loaded == []
    free = tuple(face.__class__(face.name, face.cls, face.utility) for face in FACES)
    CachedSolver().prepare(problem([], free, CPU))
    assert loaded == [CPSAT]
