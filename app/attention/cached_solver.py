"""A solver that remembers its answers, for the Intention Translator."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection
from dataclasses import dataclass, replace

from app.attention.problem import Selection, SelectionProblem
from app.attention.reasons import explain
from app.attention.solver import foreseen, load, solve


@dataclass(frozen=True, slots=True)
class CacheStatistics:
    """``size`` answers kept now; ``hits`` and ``misses`` since the start."""

    size: int
    hits: int
    misses: int


class CachedSolver:
    """``solve`` with a bounded cache of equal problems (the least recently used is dropped).

    Problems are equal if their desires are equal but for source, time and parameters, over the same table. Only proven
    selections are cached. Answers have their ``reasons`` without alternatives. Use from one thread at a time. Unless
    ``timed``, answers contain no solve time: two runs of the same program can be compared.
    """

    def __init__(self, *, size: int = 256, time_limit_s: float = 1.0, timed: bool = True) -> None:
        self.time_limit_s = time_limit_s
        self._timed = timed
        self._size = size
        self._answers: OrderedDict[object, Selection] = OrderedDict()
        self._table: object = None
        self._hits = 0
        self._misses = 0

    def recall(self, problem: SelectionProblem) -> Selection | None:
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

    def solve(self, problem: SelectionProblem) -> Selection:
        """As :func:`solve`, from the cache if the answer is there."""
        known = self.recall(problem)
        if known is not None:
            return known
        self._misses += 1
        selection = self._explained(problem, solve(problem, time_limit_s=self.time_limit_s))
        if selection.proven:
            self._answers[_key(problem)] = selection
            if len(self._answers) > self._size:
                self._answers.popitem(last=False)
        return selection

    def among(self, problem: SelectionProblem, names: Collection[str]) -> Selection:
        """As :func:`solve` with the strategies ``names`` alone; the answer is neither cached nor taken from the
        cache."""
        only = frozenset(names)
        smaller = replace(problem, strategies=tuple(s for s in problem.strategies if s.name in only))
        return self._explained(problem, solve(smaller, time_limit_s=self.time_limit_s))

    def _explained(self, problem: SelectionProblem, selection: Selection) -> Selection:
        reasons = explain(problem, selection, time_limit_s=0.0)
        return replace(selection, reasons=reasons, solve_time_s=selection.solve_time_s if self._timed else 0.0)

    def prepare(self, problem: SelectionProblem) -> None:
        """Load the libraries that problems over this table may need, so that the first problem does not wait for them.
        Blocks."""
        for search in foreseen(problem.table):
            load(search)

    def statistics(self) -> CacheStatistics:
        return CacheStatistics(len(self._answers), self._hits, self._misses)


def _key(problem: SelectionProblem) -> object:
    return (
        tuple((d.cls, d.intensity, d.utility, d.security) for d in problem.desires.values()),
        tuple(problem.capacities.items()),
        problem.previous,
        problem.weights,
        problem.thrift,
    )
