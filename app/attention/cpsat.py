"""The selection problem for OR-Tools CP-SAT: any structure, bounded time.

One worker, ``linearization_level=2``. Where all strategies of a class exclude each other, f_k is the sum of "selected
and fulfilling" literals, which needs no product; other classes linearize f_k a_s. The criteria are maximised in
lexicographic order, as many at once as provably fit into 53 bits.
"""

from __future__ import annotations

import math
import time
from typing import Any

from ortools.sat.python import cp_model

from app.attention.instance import Answer, Criterion, Infeasible, Instance

_BITS = 53
"""Bound of one objective: coefficients and sums stay exact even where the solver looks at them as doubles."""


def solve_cpsat(instance: Instance, deadline: float, hint: tuple[int, ...] = ()) -> Answer | None:
    """The lexicographic optimum, or the best found until ``deadline`` (seconds of ``time.perf_counter``).

    None: none was found in time. Raises Infeasible if the security desires cannot all be met.
    """
    if instance.impossible:
        raise Infeasible
    model = cp_model.CpModel()
    count = len(instance.cls)
    # Linear expressions; 0 where a strategy can neither be chosen nor serve.
    chosen: list[Any] = [0] * count
    serving: list[Any] = [0] * count
    fulfilled: dict[int, Any] = {}
    literals: list[cp_model.IntVar] = []
    hints: list[tuple[cp_model.IntVar, int]] = []
    for k, group in enumerate(instance.members):
        wanted = instance.desired.get(k)
        if all(len(instance.conflicts[s]) == len(group) - 1 for s in group):
            ways = []
            for s in group:
                parts = []
                if wanted is not None and instance.utility[s] >= wanted:
                    serving[s] = model.new_bool_var("")
                    parts.append(serving[s])
                if wanted is None or k in instance.needed:
                    parts.append(model.new_bool_var(""))
                chosen[s] = sum(parts)
                ways += parts
                hints += [(part, int(s in hint and part is parts[0])) for part in parts]
            model.add_at_most_one(ways)
            literals += ways
            if wanted is not None:
                fulfilled[k] = sum(serving[s] for s in group)
        else:
            for s in group:
                chosen[s] = model.new_bool_var("")
                literals.append(chosen[s])
                hints.append((chosen[s], int(s in hint)))
                for other in instance.conflicts[s]:
                    if other < s:
                        model.add_at_most_one([chosen[s], chosen[other]])
            if wanted is not None:
                fulfilled[k] = model.new_bool_var("")
                for s in group:
                    serving[s] = model.new_bool_var("")
                    model.add_implication(serving[s], chosen[s])
                    model.add_implication(serving[s], fulfilled[k])
    for k, group in enumerate(instance.members):
        wanted = instance.desired.get(k)
        if wanted is not None or k in instance.needed:
            cover: Any = sum(instance.utility[s] * chosen[s] for s in group) - sum(
                needs[k] * chosen[s] for s, needs in enumerate(instance.requires) if k in needs
            )
            model.add(cover >= (wanted * fulfilled[k] if wanted is not None else 0))
        if k in instance.security:
            model.add(fulfilled[k] == 1)
    for j, capacity in enumerate(instance.capacities):
        model.add(sum(instance.costs[s][j] * chosen[s] for s in range(count)) <= capacity)
    for variable, value in hints:
        model.add_hint(variable, value)

    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.linearization_level = 2
    solver.parameters.random_seed = 0
    # Or the process is left without its handler of Ctrl-C: CP-SAT takes the signal, and gives it back to the system.
    solver.parameters.catch_sigint_signal = False
    best: tuple[int, ...] | None = None
    bound = instance.criteria[0].high
    for number, (stage, reach, shift) in enumerate(_stages(instance)):
        objective: Any = (
            sum(gain * fulfilled[k] for k, gain in stage.fulfil.items())
            + sum(gain * serving[s] for s, gain in enumerate(stage.serve) if gain)
            - sum(cost * chosen[s] for s, cost in enumerate(stage.pay) if cost)
        )
        left = deadline - time.perf_counter()
        if left <= 0:
            return None if best is None else Answer(best, bound, False)
        model.maximize(objective)
        solver.parameters.max_time_in_seconds = left
        status = solver.solve(model)
        if status == cp_model.INFEASIBLE:
            raise Infeasible
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            return None if best is None else Answer(best, bound, False)
        best = tuple(s for s in range(count) if not isinstance(chosen[s], int) and solver.value(chosen[s]))
        # Counted in whole numbers: the solver's own figure is a double.
        value = int(solver.value(objective))
        if number == 0:
            most = value if status == cp_model.OPTIMAL else math.ceil(solver.best_objective_bound)
            # What the criteria packed below Ω contribute lies in [-shift, reach - shift[.
            bound = (most + shift) // reach
        if status != cp_model.OPTIMAL:
            return Answer(best, bound, False)
        model.add(objective == value)
        model.clear_hints()  # type: ignore[no-untyped-call]
        for variable in literals:
            model.add_hint(variable, solver.value(variable))
    assert best is not None
    return Answer(best, bound, True)


def _stages(instance: Instance) -> list[tuple[Criterion, int, int]]:
    """The criteria packed into few objectives; with each the radix of what is below its first criterion, and its
    least."""
    todo = [*instance.criteria[:-1], *_table_order(len(instance.cls))]
    stages: list[tuple[Criterion, int, int]] = []
    while todo:
        stage, reach, shift = todo.pop(0), 1, 0
        while todo and (stage.high + stage.low + 1) * (todo[0].high + todo[0].low + 1) < 1 << _BITS:
            lower = todo.pop(0)
            radix = lower.high + lower.low + 1
            reach, shift = reach * radix, shift * radix + lower.low
            stage = Criterion(
                {k: stage.fulfil.get(k, 0) * radix + lower.fulfil.get(k, 0) for k in {*stage.fulfil, *lower.fulfil}},
                tuple(a * radix + b for a, b in zip(stage.serve, lower.serve, strict=True)),
                tuple(a * radix + b for a, b in zip(stage.pay, lower.pay, strict=True)),
                stage.low * radix + lower.low,
                stage.high * radix + lower.high,
            )
        stages.append((stage, reach, shift))
    return stages


def _table_order(count: int, chunk: int = 30) -> list[Criterion]:
    """Table order in pieces of ``chunk`` strategies, the first of them deciding first."""
    pieces = []
    for start in range(0, count, chunk):
        stop = min(start + chunk, count)
        pay = tuple(-(1 << (stop - 1 - s)) if start <= s < stop else 0 for s in range(count))
        pieces.append(Criterion({}, (0,) * count, pay, 0, (1 << (stop - start)) - 1))
    return pieces
