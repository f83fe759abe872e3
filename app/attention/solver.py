"""Strategy selection: a pure function from a problem to its proven optimum (thesis 4.2.5, 4.3.3; equations 4.4–4.10).

``solve`` is synchronous; the Intention Translator runs it beside the event loop.
"""

from __future__ import annotations

import importlib
import math
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final

from app.attention.branching import MOST_SETS_TOGETHER, solve_small
from app.attention.class_options import list_options
from app.attention.integer_program import Infeasible, IntegerProgram, ProgramSolution, build_integer_program
from app.attention.prepared import InvalidProblem, PreparedTable
from app.attention.problem import Selection, SelectionProblem, Weights, assess, assess_chosen
from app.attention.search import solve_search
from app.messages import Alternative, Reason

__all__ = [
    "Alternative",
    "InvalidProblem",
    "Reason",
    "Selection",
    "SelectionProblem",
    "SolverFailed",
    "Weights",
    "assess",
    "solve",
]


CPSAT: Final = "app.attention.cpsat"
GRADED: Final = "app.attention.graded"


class SolverFailed(Exception):
    """No selection was found in the time given (there always is one: that which selects nothing breaks no budget)."""


def solve(problem: SelectionProblem, *, time_limit_s: float = 1.0, firm: bool = False) -> Selection:
    """The selection of greatest Ω, ties decided in the order of :mod:`app.attention.integer_program`.

    Security desires that cannot all be met are relaxed, the least intense first, and named in ``relaxed``. When the
    time is over the best selection found so far is returned with ``proven`` False and its bound. A short first search
    is never cut off, so that there is a selection to return; unless ``firm``: then late is as good as never.

    Raises InvalidProblem, or SolverFailed if the time was over before any selection was found, or before it was found
    which security desires fit together.
    """
    started = time.perf_counter()
    deadline = started + time_limit_s
    problem = problem.with_table()
    relaxed: list[str] = []
    try:
        answer = _answer(problem, frozenset(), deadline, firm)
    except Infeasible:
        relaxed = _relaxation(problem, deadline, firm)
        answer = _answer(problem, frozenset(relaxed), deadline, firm)
    if answer is None:
        raise SolverFailed(f"no selection was found within {time_limit_s:g} s")
    chosen = [problem.strategies[index] for index in answer.chosen]
    selection = assess_chosen(problem, chosen, relaxed=relaxed, bound=answer.bound, started=started)
    if selection is None:
        raise SolverFailed("the search returned a selection that breaks a constraint")
    return selection


@dataclass(frozen=True, slots=True)
class _Answer:
    """``chosen`` by index in the table; ``bound`` of Ω, None where the choice is proven."""

    chosen: tuple[int, ...]
    bound: float | None


def _answer(problem: SelectionProblem, relaxed: frozenset[str], deadline: float, firm: bool) -> _Answer | None:
    """The optimum without γ4 for the classes ``relaxed``, or the best found in time. Raises Infeasible."""
    small = solve_small(problem, relaxed)
    if small is not None:
        return _Answer(small, None)
    instance = build_integer_program(problem, relaxed=relaxed)
    found = _solve_instance(instance, deadline, firm)
    if found is None:
        return None
    chosen = tuple(instance.table[s] for s in found.chosen)
    return _Answer(chosen, None if found.proven else instance.omega_of(found.bound))


def _solve_instance(instance: IntegerProgram, deadline: float, firm: bool) -> ProgramSolution | None:
    """Label search where one graded resource is contended for, the compiled search where there are several; CP-SAT goes
    on from what they found."""
    answer = None
    choice = list_options(instance, deadline if firm else math.inf)
    if choice is not None:
        answer = solve_search(instance, deadline, choice=choice, firm=firm)
        if (answer is None or not answer.proven) and choice.graded > 1:
            graded = load(GRADED, deadline)
            answer = graded.solve_graded(instance, choice, deadline, answer) if graded is not None else answer
    if answer is not None and answer.proven:
        return answer
    cpsat = load(CPSAT, deadline)
    if cpsat is None:
        return answer
    other: ProgramSolution | None = cpsat.solve_cpsat(instance, deadline, answer.chosen if answer is not None else ())
    if answer is None or other is None:
        return other or answer
    bound = min(answer.bound, other.bound)
    better = other if instance.value(other.chosen) >= instance.value(answer.chosen) else answer
    return replace(better, bound=bound, proven=other.proven)


def foreseen(table: PreparedTable) -> tuple[str, ...]:
    """The searches that problems over ``table`` may need and that take time to load: for several graded resources, for
    the reasons of a large table, or for many sets of a class's strategies."""
    amounts: dict[str, set[int]] = {}
    users: dict[str, set[str]] = {}
    for strategy, costs in zip(table.strategies, table.costs, strict=True):
        for resource, cost in costs.items():
            amounts.setdefault(resource, set()).add(cost)
            users.setdefault(resource, set()).add(strategy.cls)
    graded = sum(len(amounts[resource]) > 1 and len(classes) > 1 for resource, classes in users.items())
    if graded > 1:
        return GRADED, CPSAT
    together = math.prod(1 + len(members.all) for members in table.members.values())
    compiled = (GRADED,) if together > MOST_SETS_TOGETHER else ()
    return compiled if all(members.exclusive for members in table.members.values()) else (*compiled, CPSAT)


def load(name: str, deadline: float = math.inf) -> Any:
    """The module of a search, ``GRADED`` or ``CPSAT``; None where loading it, which takes up to seconds once, is not
    over by ``deadline``: it goes on."""
    if time.perf_counter() >= deadline:
        return None
    module = sys.modules.get(name)
    if module is None or getattr(module.__spec__, "_initializing", False):
        # No import can be cut off; waiting for one can.
        loading = threading.Thread(target=_import, args=(name,), name=f"load {name}", daemon=True)
        loading.start()
        left = min(deadline - time.perf_counter(), threading.TIMEOUT_MAX)
        loading.join(max(left, 0.0))
        if loading.is_alive():
            return None
    return importlib.import_module(name)


def _import(name: str) -> None:
    with suppress(ImportError):  # the import that waits for this one raises it again
        importlib.import_module(name)


def _relaxation(problem: SelectionProblem, deadline: float, firm: bool) -> list[str]:
    """The security desires that cannot be kept: each, the most intense first, is kept if it can be beside those kept.

    Raises SolverFailed if the time is over before that is known of each.
    """
    wanted = [d for d in problem.desires.values() if d.security and d.utility > 0]
    wanted.sort(key=lambda d: (-d.intensity, d.cls))
    served = {s.cls for s in problem.strategies}
    relaxed = {d.cls for d in wanted}
    for desire in wanted:
        if desire.cls not in served:
            continue
        try:
            answer = _answer(problem, frozenset(relaxed - {desire.cls}), deadline, firm)
        except Infeasible:
            continue
        if answer is None:
            raise SolverFailed("which security desires can be kept together was not found in time")
        relaxed.discard(desire.cls)
    return [d.cls for d in wanted if d.cls in relaxed]
