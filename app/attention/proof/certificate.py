"""Certificates of proven selections: made on demand, by a second pass that knows the answer (docs/certificates.md)."""

from __future__ import annotations

import json
import math
import time
from math import gcd
from typing import Any, Final

from app.attention.desires import GRAIN
from app.attention.problem import Selection, SelectionProblem, spare_resource, thrift_resource
from app.attention.proof.equations import Refused, criteria, list_choices
from app.attention.proof.prover import Limits, NotProven, Refutation

MOST_LEAVES: Final = 50_000
"""Branches of all trees of a certificate together."""


def certify(
    problem: SelectionProblem, selection: Selection, *, time_limit_s: float = math.inf, most_leaves: int = MOST_LEAVES
) -> dict[str, Any]:
    """The certificate that ``selection`` is the best of ``problem``, as it is written to a file.

    Raises NotProven if there is none of at most ``most_leaves`` branches, or not in time.
    """
    limits = Limits(most_leaves, time.perf_counter() + time_limit_s)
    stated = state(problem)
    prices: list[dict[str, int]] = []
    trees: dict[str, Any] = {}
    have = {f"resource {name}": capacity for name, capacity in stated["capacities"].items()}
    wanted = sorted(
        (d for d in problem.desires.values() if d.security and d.utility > 0), key=lambda d: (-d.intensity, d.cls)
    )
    secure: list[str] = []
    try:
        for desire in wanted:
            if desire.cls in selection.relaxed:
                groups = list_choices(stated, [*secure, desire.cls])
                trees[f"security {desire.cls}"] = Refutation(groups, have, None, ()).tree(prices, limits)
            else:
                secure.append(desire.cls)
        groups = list_choices(stated, secure)
    except Refused as failure:
        raise NotProven(str(failure)) from None
    taken = {*selection.strategies, *(f"fulfilled {cls}" for cls in selection.fulfilled if problem.desires[cls].utility)}
    chosen = [c[1] for group in groups for c in group if c[0] == taken & frozenset().union(*(f for f, _ in group))]
    equal: dict[str, int] = {}
    for row in criteria(stated):
        grain = gcd(*(amounts[row] for group in groups for _, amounts in group)) or 1
        value = sum(amounts[row] for amounts in chosen)
        goal = {**have, **equal, row: -value - grain}
        trees[row] = Refutation(groups, goal, row, equal).tree(prices, limits)
        equal[row] = -value
    return {
        "problem": stated,
        "selected": list(selection.strategies),
        "fulfilled": list(selection.fulfilled),
        "relaxed": list(selection.relaxed),
        "prices": prices,
        "trees": trees,
    }


def certificate_text(certificate: dict[str, Any]) -> str:
    """``certificate`` as JSON, a line for each entry."""
    return json.dumps(certificate, ensure_ascii=False)


def state(problem: SelectionProblem) -> dict[str, Any]:
    """``problem`` in whole thousandths, as a certificate states it."""
    weights = problem.weights
    return {
        "strategies": {
            s.name: {
                "class": s.cls,
                "utility": _whole(s.utility),
                "requires": {cls: _whole(need) for cls, need in s.requires.items()},
                "costs": {name: _whole(cost) for name, cost in s.costs.items()},
                "filters": list(s.filters),
            }
            for s in problem.strategies
        },
        "desires": {
            cls: {"intensity": _whole(d.intensity), "utility": _whole(d.utility), "security": d.security}
            for cls, d in problem.desires.items()
        },
        "capacities": {name: _whole(capacity) for name, capacity in problem.capacities.items()},
        "previous": sorted(problem.previous),
        "thrift": thrift_resource(problem) or "",
        "intensity": _whole(weights.intensity),
        "utility": _whole(weights.utility),
        "spare": _whole(weights.spare),
        "spare_of": spare_resource(problem) or "",
    }


def _whole(amount: float) -> int:
    return round(amount * GRAIN)
