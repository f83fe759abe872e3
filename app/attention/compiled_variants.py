"""Optima of a problem under other capacities, or without one of its desires, all by the compiled search.

The problem is stated once: with the strategies that cost more than there is, and with the options that each class would
have if it were not desired. A variant is then other capacities, or another range of options of one class.
"""

# mypy: allow-untyped-calls
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.attention.class_options import list_options
from app.attention.graded import Columns, steps_until
from app.attention.graded_kernels import optimum
from app.attention.integer_program import Infeasible, build_integer_program
from app.attention.problem import SelectionProblem

_STEPS_OF_ONE: Final = 400_000
_STEPS_OF_SEVERAL: Final = 20_000_000
"""Where one graded resource is contended for, the label search is there for what takes long."""

Whole = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class CompiledProblem:
    """``columns`` has the options of each class, then those that each has without its desire. ``number`` of a class is
    its place; ``produced`` by option, in thousandths, the utility for its class if it fulfils it, else 0; ``row`` of a
    resource its constraint; ``most_steps`` of the search for one optimum: beyond it other searches are sooner."""

    columns: Columns
    capacities: Whole
    number: Mapping[str, int]
    produced: Whole
    row: Mapping[str, int]
    most_steps: int

    def under(self, resource: str, capacity: int, deadline: float) -> tuple[dict[str, int], int] | None:
        """With ``capacity`` thousandths of ``resource``, no fewer than there are: the utility that each class gets,
        and what is used of the resource, all in thousandths. None where it takes longer than to ``deadline`` (of
        ``time.perf_counter``), or longer than is reasonable."""
        capacities = self.capacities.copy()
        capacities[self.row[resource]] = capacity
        classes = len(self.number)
        starts = self.columns.starts
        chosen = self._chosen(starts[:classes], starts[1 : classes + 1], capacities, deadline)
        if chosen is None:
            return None
        return self._got(chosen), int(self.columns.costs[self.row[resource], chosen].sum())

    def without(self, cls: str, deadline: float) -> dict[str, int] | None:
        """Without the desire for ``cls``, which is not inhibited: as :meth:`under`."""
        classes = len(self.number)
        starts, k = self.columns.starts, self.number[cls]
        first, last = starts[:classes].copy(), starts[1 : classes + 1].copy()
        first[k], last[k] = starts[classes + k], starts[classes + k + 1]
        chosen = self._chosen(first, last, self.capacities, deadline)
        return None if chosen is None else self._got(chosen)

    def _chosen(self, first: Whole, last: Whole, capacities: Whole, deadline: float) -> Whole | None:
        status, _, _, chosen = optimum(
            first=first,
            last=last,
            losses=self.columns.losses,
            costs=self.columns.costs,
            strategies=self.columns.strategies,
            capacities=self.columns.usable(capacities),
            most=steps_until(deadline, self.most_steps),
        )
        return chosen if status == 0 else None

    def _got(self, chosen: Whole) -> dict[str, int]:
        return dict(zip(self.number, self.produced[chosen].tolist(), strict=True))


def compile_problem(problem: SelectionProblem, deadline: float) -> CompiledProblem | None:
    """``problem``, whose security desires can all be met, for the compiled search; None if it is not for it (a class
    with very many independent strategies; a desire that is worth nothing), or ``deadline`` comes first. Raises
    InvalidProblem."""
    instance = build_integer_program(problem, roomier=True)
    try:
        choice = list_options(instance, deadline, with_idle=True)
    except Infeasible:
        return None
    if choice is None or not choice.capacities:
        return None
    gains = [
        instance.fulfil[k] + sum([instance.serve[s] for s in option.strategies])
        for k, group in enumerate(choice.groups)
        for option in group
        if option.serves
    ]
    if min(gains, default=1) <= 0:
        # Whether such a class counts as fulfilled would not follow from its option.
        return None
    groups = [*enumerate(choice.groups), *enumerate(choice.idle)]
    columns = Columns.of(instance.criteria[:-1], groups, len(choice.capacities))
    produced = [
        sum([instance.utility[s] for s in option.strategies]) if option.serves else 0
        for _, group in groups
        for option in group
    ]
    resources = dict(enumerate(instance.resources))
    return CompiledProblem(
        columns,
        np.array(choice.capacities, dtype=np.int64),
        number={name: k for k, name in enumerate(instance.classes)},
        produced=np.array(produced, dtype=np.int64),
        row={resources[j]: row for row, j in enumerate(choice.constraints) if j in resources},
        most_steps=_STEPS_OF_ONE if choice.graded <= 1 else _STEPS_OF_SEVERAL,
    )
