"""Strategy selection: a pure function from a problem to its proven optimum (thesis 4.2.5, 4.3.3; equations 4.4–4.10).

``solve`` is synchronous; the Intention Translator runs it beside the event loop.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from dataclasses import dataclass, replace

from app.attention.instance import Answer, Infeasible, Instance, build_instance
from app.attention.problem import (
    Alternative,
    InvalidProblem,
    Problem,
    Reason,
    Selection,
    Weights,
    assess,
)
from app.attention.search import solve_search

__all__ = [
    "Alternative",
    "CachedSolver",
    "InvalidProblem",
    "Problem",
    "Reason",
    "Selection",
    "SolverFailed",
    "Weights",
    "assess",
    "solve",
]


class SolverFailed(Exception):
    """No selection was found in the time given (there always is one: that which selects nothing breaks no budget)."""


def solve(problem: Problem, *, time_limit_s: float = 1.0) -> Selection:
    """The selection of greatest Ω, ties decided in the order of :mod:`app.attention.instance`.

    Security desires that cannot all be met are relaxed, the least intense first, and named in ``relaxed``. When the
    time is over the best selection found so far is returned with ``proven`` False and its bound.

    Raises InvalidProblem, or SolverFailed if the time was over before any selection was found.
    """
    started = time.perf_counter()
    deadline = started + time_limit_s
    relaxed: list[str] = []
    try:
        instance = build_instance(problem)
        answer = _solve_instance(instance, deadline)
    except Infeasible:
        relaxed = _relaxation(problem, deadline)
        instance = build_instance(problem, relaxed=frozenset(relaxed))
        answer = _solve_instance(instance, deadline)
    if answer is None:
        raise SolverFailed(f"no selection was found within {time_limit_s:g} s")
    names = {problem.strategies[instance.table[s]].name for s in answer.chosen}
    selection = assess(problem, names, relaxed=relaxed)
    if selection is None:
        raise SolverFailed("the search returned a selection that breaks a constraint")
    return replace(
        selection,
        proven=answer.proven,
        bound=selection.omega if answer.proven else max(selection.omega, instance.omega_of(answer.bound)),
        solve_time_s=time.perf_counter() - started,
    )


def _solve_instance(instance: Instance, deadline: float) -> Answer | None:
    """Label search where the structure allows it (nearly always), else CP-SAT, started from what the search found."""
    answer = solve_search(instance, deadline)
    if answer is not None and (answer.proven or time.perf_counter() >= deadline):
        return answer
    # Loading CP-SAT takes most of a second; few programs ever need it, and it is not charged to the search.
    started = time.perf_counter()
    from app.attention.cpsat import solve_cpsat

    deadline += time.perf_counter() - started
    hint = answer.chosen if answer is not None else ()
    other = solve_cpsat(instance, deadline, hint)
    if answer is None or other is None:
        return other or answer
    bound = min(answer.bound, other.bound)
    better = other if instance.value(other.chosen) >= instance.value(answer.chosen) else answer
    return replace(better, bound=bound, proven=other.proven)


def _relaxation(problem: Problem, deadline: float) -> list[str]:
    """The security desires that cannot be kept: each, the most intense first, is kept if it can be beside those
    kept."""
    wanted = [d for d in problem.desires.values() if d.security and d.utility > 0]
    wanted.sort(key=lambda d: (-d.intensity, d.cls))
    relaxed = {d.cls for d in wanted}
    for desire in wanted:
        try:
            _solve_instance(build_instance(problem, relaxed=frozenset(relaxed - {desire.cls})), deadline)
        except Infeasible:
            continue
        relaxed.discard(desire.cls)
    return [d.cls for d in wanted if d.cls in relaxed]


@dataclass(frozen=True, slots=True)
class CacheStatistics:
    """``size`` answers kept now; ``hits`` and ``misses`` since the start."""

    size: int
    hits: int
    misses: int


class CachedSolver:
    """``solve`` with a bounded memory of equal problems (the least recently asked is forgotten).

    Problems are equal if they ask the same of the same table: who desires, since when and with which parameters does
    not matter. Only proven selections are remembered. Use from one thread at a time. Unless ``timed``, no answer tells
    how long it took: two runs of the same program can be compared.
    """

    def __init__(self, *, size: int = 256, time_limit_s: float = 1.0, timed: bool = True) -> None:
        self.time_limit_s = time_limit_s
        self._timed = timed
        self._size = size
        self._answers: OrderedDict[object, Selection] = OrderedDict()
        self._table: object = None
        self._hits = 0
        self._misses = 0

    def recall(self, problem: Problem) -> Selection | None:
        """The answer to an equal problem, with the solve time it took when it was found; None if it is not
        remembered."""
        if problem.strategies is not self._table:
            self._answers.clear()
            self._table = problem.strategies
        key = _key(problem)
        known = self._answers.get(key)
        if known is not None:
            self._hits += 1
            self._answers.move_to_end(key)
        return known

    def solve(self, problem: Problem) -> Selection:
        """As :func:`solve`, from memory if it is there."""
        known = self.recall(problem)
        if known is not None:
            return known
        self._misses += 1
        selection = solve(problem, time_limit_s=self.time_limit_s)
        if not self._timed:
            selection = replace(selection, solve_time_s=0.0)
        if selection.proven:
            self._answers[_key(problem)] = selection
            if len(self._answers) > self._size:
                self._answers.popitem(last=False)
        return selection

    def statistics(self) -> CacheStatistics:
        return CacheStatistics(len(self._answers), self._hits, self._misses)


def _key(problem: Problem) -> object:
    return (
        tuple((d.cls, d.intensity, d.utility, d.security) for d in problem.desires.values()),
        tuple(problem.capacities.items()),
        problem.previous,
        problem.weights,
        problem.thrift,
    )
