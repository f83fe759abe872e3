"""The selection problem for OR-Tools CP-SAT: any structure, bounded time.

One worker, ``linearization_level=2``. Where all strategies of a class exclude each other, f_k is the sum of "selected
and fulfilling" literals, which needs no product; other classes linearize f_k a_s. The criteria are maximised in
lexicographic order, as many at once as provably fit into 53 bits.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator
from typing import Any

from ortools.sat.python import cp_model

from app.attention.integer_program import Criterion, Infeasible, IntegerProgram, ProgramSolution, table_order

_BITS = 53
"""Bound of one objective: coefficients and sums stay exact even where the solver looks at them as doubles."""


def solve_cpsat(instance: IntegerProgram, deadline: float, hint: tuple[int, ...] = ()) -> ProgramSolution | None:
    """The lexicographic optimum, or the best found until ``deadline`` (seconds of ``time.perf_counter``).

    None: none was found in time. Raises Infeasible if the security desires cannot all be met.
    """
    if instance.impossible:
        raise Infeasible
    selection = _Selection(instance, hint)
    if not selection.stated_by(deadline):
        return None
    model, solver = selection.model, _solver()
    best: tuple[int, ...] | None = None
    bound = instance.criteria[0].high
    for number, (stage, reach, shift) in enumerate(_stages(instance)):
        objective = selection.objective(stage)
        left = deadline - time.perf_counter()
        if left <= 0:
            return None if best is None else ProgramSolution(best, bound, False)
        model.maximize(objective)
        solver.parameters.max_time_in_seconds = left
        status = solver.solve(model)
        if status == cp_model.INFEASIBLE:
            raise Infeasible
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            return None if best is None else ProgramSolution(best, bound, False)
        best = tuple(
            s for s, variable in enumerate(selection.chosen) if not isinstance(variable, int) and solver.value(variable)
        )
        # Counted in whole numbers: the solver's own figure is a double.
        value = int(solver.value(objective))
        if number == 0:
            most = value if status == cp_model.OPTIMAL else math.ceil(solver.best_objective_bound)
            # The sum of the criteria packed below Ω is in [-shift, reach - shift[.
            bound = (most + shift) // reach
        if status != cp_model.OPTIMAL:
            return ProgramSolution(best, bound, False)
        model.add(objective == value)
        model.clear_hints()  # type: ignore[no-untyped-call]
        for variable in selection.literals:
            model.add_hint(variable, solver.value(variable))
    assert best is not None
    return ProgramSolution(best, bound, True)


def _solver() -> cp_model.CpSolver:
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.linearization_level = 2
    solver.parameters.random_seed = 0
    # Or the process is left without its handler of Ctrl-C: CP-SAT takes the signal, and gives it back to the system.
    solver.parameters.catch_sigint_signal = False
    return solver


class _Selection:
    """The problem's constraints in ``model``. By strategy s, ``chosen`` and ``serving`` are linear expressions, 0 where
    it can neither be chosen nor serve; ``fulfilled`` by class k; ``literals`` are what is decided."""

    def __init__(self, instance: IntegerProgram, hint: tuple[int, ...]) -> None:
        self.model = cp_model.CpModel()
        self.chosen: list[Any] = [0] * len(instance.cls)
        self.serving: list[Any] = [0] * len(instance.cls)
        self.fulfilled: dict[int, Any] = {}
        self.literals: list[cp_model.IntVar] = []
        self._instance = instance
        self._hinted = hint
        self._hints: list[tuple[cp_model.IntVar, int]] = []

    def stated_by(self, deadline: float) -> bool:
        """Write the problem into the model; False if the deadline came first."""
        instance = self._instance
        for k, group in enumerate(instance.members):
            if time.perf_counter() > deadline:
                return False
            if instance.exclusive[k]:
                self._at_most_one(k, group)
            else:
                self._several(k, group)
        self._cover()
        for j, capacity in enumerate(instance.capacities):
            self.model.add(sum(costs[j] * a for costs, a in zip(instance.costs, self.chosen, strict=True)) <= capacity)
        for variable, value in self._hints:
            self.model.add_hint(variable, value)
        return time.perf_counter() <= deadline

    def objective(self, stage: Criterion) -> Any:
        """``stage`` as a linear expression."""
        return (
            sum(gain * self.fulfilled[k] for k, gain in stage.fulfil.items())
            + sum(gain * self.serving[s] for s, gain in enumerate(stage.serve) if gain)
            - sum(cost * self.chosen[s] for s, cost in enumerate(stage.pay) if cost)
        )

    def _at_most_one(self, k: int, group: tuple[int, ...]) -> None:
        """A class whose strategies all exclude each other: each is selected to serve the class, or only because others
        require it."""
        instance, wanted = self._instance, self._instance.desired.get(k)
        ways: list[cp_model.IntVar] = []
        for s in group:
            parts = []
            if wanted is not None and instance.utility[s] >= wanted:
                self.serving[s] = self.model.new_bool_var("")
                parts.append(self.serving[s])
            if wanted is None or k in instance.needed:
                parts.append(self.model.new_bool_var(""))
            self.chosen[s] = sum(parts)
            ways += parts
            self._hints += [(part, int(s in self._hinted and part is parts[0])) for part in parts]
        self.model.add_at_most_one(ways)
        self.literals += ways
        if wanted is not None:
            self.fulfilled[k] = sum(self.serving[s] for s in group)

    def _several(self, k: int, group: tuple[int, ...]) -> None:
        """A class of which several may be chosen: one serves where it is chosen and all of them together suffice."""
        for s in group:
            self.chosen[s] = self.model.new_bool_var("")
            self.literals.append(self.chosen[s])
            self._hints.append((self.chosen[s], int(s in self._hinted)))
        for clique in self._instance.cliques[k]:
            self.model.add_at_most_one([self.chosen[s] for s in clique])
        if k in self._instance.desired:
            self.fulfilled[k] = self.model.new_bool_var("")
            for s in group:
                self.serving[s] = self.model.new_bool_var("")
                self.model.add_implication(self.serving[s], self.chosen[s])
                self.model.add_implication(self.serving[s], self.fulfilled[k])

    def _cover(self) -> None:
        """Constraints: the produced utility of a class, less the utility required of it, reaches the desired utility
        where the class counts as fulfilled, and is never negative."""
        instance = self._instance
        drawn: dict[int, list[Any]] = {k: [] for k in instance.needed}
        for s, needs in enumerate(instance.requires):
            for k, amount in needs.items():
                drawn[k].append(amount * self.chosen[s])
        for k, group in enumerate(instance.members):
            wanted = instance.desired.get(k)
            if wanted is not None or k in instance.needed:
                cover: Any = sum(instance.utility[s] * self.chosen[s] for s in group) - sum(drawn.get(k, ()))
                self.model.add(cover >= (wanted * self.fulfilled[k] if wanted is not None else 0))
            if k in instance.security:
                self.model.add(self.fulfilled[k] == 1)


def _stages(instance: IntegerProgram) -> Iterator[tuple[Criterion, int, int]]:
    """The criteria packed into few objectives; with each the radix of what is below its first criterion, and its
    least."""
    todo = itertools.chain(instance.criteria[:-1], table_order(len(instance.cls)))
    following = next(todo, None)
    while following is not None:
        stage, reach, shift = following, 1, 0
        following = next(todo, None)
        while following and (stage.high + stage.low + 1) * (following.high + following.low + 1) < 1 << _BITS:
            lower, following = following, next(todo, None)
            radix = lower.high + lower.low + 1
            reach, shift = reach * radix, shift * radix + lower.low
            stage = Criterion(
                {k: stage.fulfil.get(k, 0) * radix + lower.fulfil.get(k, 0) for k in {*stage.fulfil, *lower.fulfil}},
                tuple(a * radix + b for a, b in zip(stage.serve, lower.serve, strict=True)),
                tuple(a * radix + b for a, b in zip(stage.pay, lower.pay, strict=True)),
                stage.low * radix + lower.low,
                stage.high * radix + lower.high,
            )
        yield stage, reach, shift
