"""The independent checker of certificates (docs/certificates.md): is a selection the best there is, ties and all?

It shares no code with the solver. All numbers are whole, so nothing is rounded. In a selection better than the stated
one no row (:mod:`app.attention.proof.equations`) is negative, the criterion that is better exceeds the stated one's,
and those before it are equal. So prices close a branch if the priced sum of rows is negative whatever is chosen in it.
"""

import json
from functools import cache
from math import gcd
from typing import Any

from app.attention.proof.equations import Refused, criteria, list_choices


def check(text: str) -> int:
    """Ω, in millionths, of the selection that the certificate ``text`` (JSON) proves to be the best. Raises Refused."""
    try:
        return _check(**json.loads(text, parse_float=int, parse_constant=int))
    except (ArithmeticError, LookupError, TypeError, AttributeError, ValueError, RecursionError) as failure:
        raise failure if isinstance(failure, Refused) else Refused(f"it is not whole: {failure!r}") from None


def _check(certificate: Any, problem: Any, selected: Any, fulfilled: Any, relaxed: Any, trees: Any, prices: Any) -> int:
    _require(certificate == 1, "its version is not 1")
    have, secure = {f"resource {name}": capacity for name, capacity in problem["capacities"].items()}, list[str]()
    for cls, desire in sorted(problem["desires"].items(), key=lambda item: (-item[1]["intensity"], item[0])):
        if desire["security"] and desire["utility"] and cls in relaxed:  # impossible beside those that are kept
            _refute(list_choices(problem, [*secure, cls]), have, trees[f"security {cls}"], prices, {})
        secure += [cls] * bool(desire["security"] and desire["utility"] and cls not in relaxed)
    groups, taken = list_choices(problem, secure), {*selected, *(f"fulfilled {cls}" for cls in fulfilled)}
    chosen = [c for group in groups for c in group if c[0] == taken & frozenset().union(*(facts for facts, _ in group))]
    _require(len(chosen) == len(groups) and taken == {f for c in chosen for f in c[0]}, "its selection is impossible")
    reached = {row: sum(rows[row] for _, rows in chosen) for group in groups for _, some in group for row in some}
    broken = [row for row, n in reached.items() if row[:4] != "crit" and n + have.get(row, 0) < 0]
    _require(not broken, f"its selection exceeds {', '.join(broken)}")
    equal: dict[str, int] = {}
    for row in criteria(problem):
        # Sums are multiples of the grain: a better selection exceeds this one by that.
        grain = gcd(*(rows[row] for group in groups for _, rows in group)) or 1
        _refute(groups, have | equal | {row: -reached.get(row, 0) - grain}, trees[row], prices, equal)
        equal[row] = -reached.get(row, 0)
    spare = problem["spare"] * have.get(f"resource {problem['spare_of']}", 0)
    return sum((rows["criterion 0"] for _, rows in chosen), int(spare))


def _refute(groups: Any, have: dict[str, int], tree: Any, prices: Any, equal: dict[str, int]) -> None:
    """Refuse ``tree`` unless it closes all choices whose rows, with ``have``, are 0 in ``equal`` and ≥ 0 elsewhere.
    A fact in it parts a branch into that without it, which follows, and that with it. A number closes a branch by that
    entry of ``prices``."""
    owner = {fact: k for k, group in enumerate(groups) for facts, _ in group for fact in facts}

    @cache
    def most(at: int, k: int, left: tuple[int, ...]) -> int:
        best: int = max(sum(price * groups[k][c][1][row] for row, price in prices[at].items()) for c in left)
        return best

    branches = [[tuple(range(len(group))) for group in groups]]
    for at in tree:
        left = branches.pop()
        if isinstance(at, int):
            fixed = sum(price * (0 if row[:6] == "class " else have[row]) for row, price in prices[at].items())
            _require(all(n >= 0 or row in equal for row, n in prices[at].items()), f"prices {at}: one is negative")
            closed = not all(left) or fixed + sum(most(at, k, part) for k, part in enumerate(left)) < 0
            _require(closed, f"prices {at} do not close a branch")
        else:
            for given in (True, False):
                part = tuple(c for c in left[owner[at]] if (at in groups[owner[at]][c][0]) is given)
                branches.append([part if k == owner[at] else other for k, other in enumerate(left)])
    _require(not branches, "a branch is missing")


def _require(holds: bool, why: str) -> None:
    if not holds:
        raise Refused(why)
