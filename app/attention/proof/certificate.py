"""Certificates of proven selections, made on demand by a second pass that knows the answer (docs/certificates.md)."""

from __future__ import annotations

import json
import math
import time
from math import gcd
from typing import Final

from app.attention.proof.equations import Refused, criteria, list_choices
from app.attention.proof.prover import Limits, NotProven, Refutation
from app.attention.proof.statement import Claim

MOST_LEAVES: Final = 50_000
"""Branches of all trees of a certificate together: about 15 MB, and twenty seconds to check."""
HEAD: Final = '{"certificate": 1'
"""The first characters of every certificate."""


def certify(claim: Claim, *, time_limit_s: float = math.inf, most_leaves: int = MOST_LEAVES) -> str:
    """The certificate of ``claim``, JSON. Raises NotProven if there is none with at most ``most_leaves`` branches, or
    none in time."""
    try:
        trees, prices = _proof(claim, Limits(most_leaves, time.perf_counter() + time_limit_s))
    except Refused as failure:
        raise NotProven(str(failure)) from None
    members = {
        "problem": claim.problem,
        "selected": claim.selected,
        "fulfilled": claim.fulfilled,
        "relaxed": claim.relaxed,
        "trees": trees,
    }
    entries = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in prices)
    rest = "".join(f",\n{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in members.items())
    return f'{HEAD}{rest},\n"prices": [\n{entries}\n]}}\n'


def _proof(claim: Claim, limits: Limits) -> tuple[dict[str, list[str | int]], list[dict[str, int]]]:
    problem = claim.problem
    prices: list[dict[str, int]] = []
    trees: dict[str, list[str | int]] = {}
    have = {f"resource {name}": capacity for name, capacity in problem["capacities"].items()}
    secure: list[str] = []
    for cls, desire in sorted(problem["desires"].items(), key=lambda item: (-item[1]["intensity"], item[0])):
        if not (desire["security"] and desire["utility"]):
            continue
        if cls in claim.relaxed:
            impossible = Refutation(list_choices(problem, [*secure, cls]), have, None, ())
            trees[f"security {cls}"] = impossible.tree(prices, limits)
        else:
            secure.append(cls)
    groups = list_choices(problem, secure)
    taken = {*claim.selected, *(f"fulfilled {cls}" for cls in claim.fulfilled)}
    chosen = [c[1] for group in groups for c in group if c[0] == taken & frozenset().union(*(f for f, _ in group))]
    equal: dict[str, int] = {}
    for row in criteria(problem):
        grain = gcd(*(amounts[row] for group in groups for _, amounts in group)) or 1
        value = sum(amounts[row] for amounts in chosen)
        better = Refutation(groups, {**have, **equal, row: -value - grain}, row, equal)
        trees[row] = better.tree(prices, limits)
        equal[row] = -value
    return trees, prices
