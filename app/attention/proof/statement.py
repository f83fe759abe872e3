"""A selection problem, and what is claimed of it, as certificates state them: amounts are whole thousandths."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol

from app.attention.desires import GRAIN
from app.attention.problem import Selection, SelectionProblem, spare_resource, thrift_resource

TABLE_FILE: Final = "attention-table.json"
"""The attachment of a recording with the table of strategies as attention had it."""


class Asked(Protocol):
    """What a desire asks for."""

    @property
    def intensity(self) -> float: ...
    @property
    def utility(self) -> float: ...
    @property
    def security(self) -> bool: ...


@dataclass(frozen=True, slots=True)
class Claim:
    """What a certificate proves: that of ``problem``, as :func:`state` states it, ``selected`` is the best selection;
    it fulfils the classes ``fulfilled``, and no selection meets the security desires for those ``relaxed``."""

    problem: Mapping[str, Any]
    selected: tuple[str, ...]
    fulfilled: tuple[str, ...]
    relaxed: tuple[str, ...] = ()


def claim_of(problem: SelectionProblem, selection: Selection) -> Claim:
    """What a proven ``selection`` claims of ``problem``."""
    stated = state(state_table(problem), problem.desires, problem.capacities, problem.previous)
    return Claim(stated, selection.strategies, selection.fulfilled, selection.relaxed)


def state(
    table: Mapping[str, Any],
    desires: Mapping[str, Asked],
    capacities: Mapping[str, float],
    previous: Collection[str],
) -> dict[str, Any]:
    """A problem over ``table`` (:func:`state_table`) as certificates state it."""
    return {
        **table,
        "desires": {
            cls: {"intensity": whole(d.intensity), "utility": whole(d.utility), "security": d.security}
            for cls, d in desires.items()
        },
        "capacities": {name: whole(capacity) for name, capacity in capacities.items()},
        "previous": sorted(previous),
    }


def state_table(problem: SelectionProblem) -> dict[str, Any]:
    """What all problems over a table have in common."""
    weights = problem.weights
    return {
        "strategies": {
            s.name: {
                "class": s.cls,
                "utility": whole(s.utility),
                "requires": {cls: whole(need) for cls, need in s.requires.items()},
                "costs": {name: whole(cost) for name, cost in s.costs.items()},
                "filters": list(s.filters),
            }
            for s in problem.strategies
        },
        "thrift": thrift_resource(problem) or "",
        "intensity": whole(weights.intensity),
        "utility": whole(weights.utility),
        "spare": whole(weights.spare),
        "spare_of": spare_resource(problem) or "",
    }


def whole(amount: float) -> int:
    """``amount`` in thousandths."""
    return round(amount * GRAIN)


def table_data(problem: SelectionProblem) -> bytes:
    """The table of ``problem`` as recordings carry it."""
    return json.dumps(state_table(problem), ensure_ascii=False, indent=1).encode()
