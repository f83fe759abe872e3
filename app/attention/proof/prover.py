"""The trees of a certificate: a search that knows the answer, and keeps what closes each branch.

Prices come from the linear relaxation of what a branch leaves (GLOP, in floating point). They become whole numbers
before their bound is looked at: so rounding may make a tree larger, never wrong. The relaxation may overstep a row at a
high price, so that prices also close a branch where nothing is possible.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from ortools.linear_solver import pywraplp

from app.attention.proof.equations import Choice

_OVERSTEP: Final = 1e4
"""The price of overstepping a row by its greatest amount, in the goal's greatest amount."""
_BITS: Final = 40
"""Of a price behind the point, where rows are in their greatest amounts."""
_SAFE: Final = 1e-9
"""Of all greatest amounts: a bound that is closer to 0 is computed in whole numbers."""

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Tree = list["str | int"]


class NotProven(Exception):
    """There is no certificate; the message says why."""


class NotBest(NotProven):
    """There is no certificate, since there is a better selection."""


@dataclass(slots=True)
class Limits:
    """What a certificate may take: ``leaves`` that are left, until ``deadline`` (of ``time.perf_counter``)."""

    leaves: int
    deadline: float

    def spend(self) -> None:
        """Count a branch. Raises NotProven."""
        self.leaves -= 1
        if self.leaves < 0:
            raise NotProven("the proof has more branches than a certificate may have")
        if time.perf_counter() > self.deadline:
            raise NotProven("the time was over before the proof was written")


@dataclass(eq=False, slots=True)
class _Prices:
    """Prices by row, and what they make of each choice and of what there is; ``size``: no sum of both is further from
    0. ``number`` of the entry; -1: none yet."""

    of: dict[str, int]
    priced: Floats
    fixed: float
    size: float
    number: int = -1


class Refutation:
    """The proof that no choices have rows, with ``have``, that are 0 in ``equal`` and at least 0 elsewhere.

    ``goal`` is the row that the others are weighed against; None: there is none.
    """

    def __init__(
        self, groups: Sequence[Sequence[Choice]], have: Mapping[str, int], goal: str | None, equal: Collection[str]
    ) -> None:
        self._choices = [choice for group in groups for choice in group]
        self._equal = frozenset(equal)
        sizes = [len(group) for group in groups]
        self._starts = np.cumsum([0, *sizes])[:-1]
        self._empty = not all(sizes)
        own = {row: 0 for _, amounts in self._choices for row in amounts if row.startswith("class ")}
        named = {**own, **have}
        #: What no choices together can make negative needs no price.
        self._have = {row: named[row] for row in named if row == goal or row in equal or _binds(groups, row, named)}
        self._amounts = np.array([[float(c[1][row]) for c in self._choices] for row in self._have])
        self._amounts = self._amounts.reshape(len(self._have), len(self._choices))
        self._scale = np.maximum(np.abs(self._amounts).max(axis=1, initial=0.0), 1.0)
        self._free = np.array([row in self._equal for row in self._have], dtype=bool)
        self._nothing = _Prices({}, np.zeros(len(self._choices)), 0.0, 0.0)
        self._relaxation = _Relaxation(
            self._amounts, self._have, self._scale, self._starts, goal=goal, equal=self._equal
        )

    def tree(self, prices: list[dict[str, int]], limits: Limits) -> Tree:
        """The tree, whose leaves number entries of ``prices``; new ones are added to it. Raises NotProven."""
        tree: Tree = []
        branches = [(np.ones(len(self._choices), dtype=bool), self._nothing)]
        while branches:
            alive, known = branches.pop()
            limits.spend()
            closing, facts = (known, []) if self._closes(alive, known) else self._parted(alive)
            if not facts:
                if closing.number < 0:
                    closing.number = len(prices)
                    prices.append(closing.of)
                tree.append(closing.number)
            # First comes what has none of the facts.
            for fact, lacking, having in facts:
                tree.append(fact)
                branches.append((alive & ~lacking, closing))
                alive = alive & ~having
            if facts:
                branches.append((alive, closing))
        return tree

    def _closes(self, alive: Mask, prices: _Prices) -> bool:
        if self._empty:
            return True
        most = np.maximum.reduceat(np.where(alive, prices.priced, -np.inf), self._starts)
        total = float(most.sum()) + prices.fixed
        if abs(total) > _SAFE * prices.size:
            return total < 0
        exact = sum(n * self._have[row] for row, n in prices.of.items())
        spans = [*self._starts, len(alive)]
        for first, end in pairwise(spans):
            left = (self._choices[place][1] for place in range(first, end) if alive[place])
            exact += max(sum(n * amounts[row] for row, n in prices.of.items()) for amounts in left)
        return exact < 0

    def _parted(self, alive: Mask) -> tuple[_Prices, list[tuple[str, Mask, Mask]]]:
        """Prices that close the branch; or the best there are, and the facts of a class to part it by, each with the
        choices of that class that lack it and those that have it. Raises NotProven."""
        weights, solution = self._relaxation.solve(alive)
        prices = self._priced(weights)
        if self._closes(alive, prices):
            return prices, []
        counts = np.add.reduceat(alive, self._starts)
        if counts.max(initial=1) == 1:
            return self._single(alive), []
        # The class that the relaxation has least decided.
        undecided = np.where(counts > 1, 1 - np.maximum.reduceat(np.where(alive, solution, 0), self._starts), -1.0)
        k = int(undecided.argmax())
        end = self._starts[k + 1] if k + 1 < len(self._starts) else len(alive)
        mine = [int(place) for place in np.flatnonzero(alive[self._starts[k] : end]) + self._starts[k]]
        shared = frozenset.intersection(*(self._choices[place][0] for place in mine))
        value: dict[str, float] = {}
        for place in mine:
            for fact in self._choices[place][0] - shared:
                value[fact] = max(value.get(fact, -np.inf), float(prices.priced[place]))
        facts = sorted(value, key=lambda fact: (fact.startswith("fulfilled "), -value[fact], fact))
        named = [fact for fact in facts if not fact.startswith("fulfilled ")] or facts
        if all(self._choices[place][0] & {*named} for place in mine):
            named.pop()
        return prices, [(fact, *self._masks(fact, mine)) for fact in named]

    def _masks(self, fact: str, mine: Sequence[int]) -> tuple[Mask, Mask]:
        """Which of the choices ``mine`` lack ``fact``, and which have it."""
        lacking, having = np.zeros((2, len(self._choices)), dtype=bool)
        for place in mine:
            (having if fact in self._choices[place][0] else lacking)[place] = True
        return lacking, having

    def _priced(self, weights: Floats) -> _Prices:
        """Whole prices of ``weights``, which are of rows in their greatest amounts."""
        weights = np.where(self._free, weights, np.maximum(weights, 0.0))
        top = float(np.abs(weights).max(initial=0.0)) or 1.0
        whole = [
            round(float(w) / top * 2**_BITS * float(self._scale.max() / s))
            for w, s in zip(weights, self._scale, strict=True)
        ]
        of = {row: n for row, n in zip(self._have, whole, strict=True) if n}
        floats = np.array(whole, dtype=np.float64)
        fixed = float(sum(n * self._have[row] for row, n in of.items()))
        size = float(np.abs(floats) @ self._scale) * len(self._starts) + sum(
            abs(n * self._have[row]) for row, n in of.items()
        )
        return _Prices(of, floats @ self._amounts, fixed, size)

    def _single(self, alive: Mask) -> _Prices:
        """Prices that close a branch where all is chosen: of the row that is broken."""
        chosen = [self._choices[place][1] for place in np.flatnonzero(alive)]
        for place, (row, have) in enumerate(self._have.items()):
            total = have + sum(amounts[row] for amounts in chosen)
            if total < 0 or (total and row in self._equal):
                sign = 1 if total < 0 else -1
                return _Prices({row: sign}, sign * self._amounts[place], float(sign * have), float("inf"))
        raise NotBest(f"there is a better selection: {', '.join(self._names(alive)) or 'nothing'}")

    def _names(self, alive: Mask) -> list[str]:
        facts = {fact for place in np.flatnonzero(alive) for fact in self._choices[place][0]}
        return sorted(fact for fact in facts if not fact.startswith("fulfilled "))


class _Relaxation:
    """The greatest ``goal`` of choices by shares, less what is overstepped."""

    def __init__(
        self,
        amounts: Floats,
        have: Mapping[str, int],
        scale: Floats,
        starts: NDArray[np.int64],
        goal: str | None,
        equal: frozenset[str],
    ) -> None:
        solver: Any = pywraplp.Solver.CreateSolver("GLOP")
        # A branch differs little from the one before: its relaxation goes on from that one's basis.
        solver.SetSolverSpecificParametersAsString("use_dual_simplex:true use_preprocessing:false")
        infinity = solver.infinity()
        self._solver = solver
        self._rows: list[Any] = []
        self._goal = list(have).index(goal) if goal is not None else -1
        self._shares = [solver.NumVar(0.0, 1.0, "") for _ in range(amounts.shape[1])]
        for first, end in zip(starts, [*starts[1:], amounts.shape[1]], strict=True):
            one = solver.Constraint(1.0, 1.0)
            for share in self._shares[first:end]:
                one.SetCoefficient(share, 1.0)
        objective = solver.Objective()
        objective.SetMaximization()
        for place, (row, least) in enumerate(have.items()):
            scaled = amounts[place] / scale[place]
            if place == self._goal:
                for share, amount in zip(self._shares, scaled, strict=True):
                    objective.SetCoefficient(share, float(amount))
                continue
            bound = -least / scale[place]
            constraint = solver.Constraint(bound, bound if row in equal else infinity)
            for share, amount in zip(self._shares, scaled, strict=True):
                if amount:
                    constraint.SetCoefficient(share, float(amount))
            for sign in (1.0, -1.0)[: 1 + (row in equal)]:
                over = solver.NumVar(0.0, infinity, "")
                constraint.SetCoefficient(over, sign)
                objective.SetCoefficient(over, -_OVERSTEP)
            self._rows.append(constraint)
        self._alive: Mask = np.ones(amounts.shape[1], dtype=bool)

    def solve(self, alive: Mask) -> tuple[Floats, Floats]:
        """(weights of the rows, the goal's 1; shares of the choices) with the choices ``alive`` alone."""
        for place in np.flatnonzero(alive != self._alive):
            self._shares[place].SetUb(float(alive[place]))
        self._alive = alive
        solved = self._solver.Solve() == pywraplp.Solver.OPTIMAL
        # Any weights are safe; without good ones the branch is parted.
        weights = np.array([-row.dual_value() if solved else 0.0 for row in self._rows])
        if self._goal >= 0:
            weights = np.insert(weights, self._goal, 1.0)
        return weights, np.array([share.solution_value() if solved else 0.0 for share in self._shares])


def _binds(groups: Sequence[Sequence[Choice]], row: str, have: Mapping[str, int]) -> bool:
    return have[row] + sum(min((amounts[row] for _, amounts in group), default=0) for group in groups) < 0
