"""A selection problem as its certificate states it, in rows: equations 4.4–4.10 and the order of ties.

A *choice* of a class is a set of its strategies that may stand together, fulfilling it or not. A *row* is a sum over
the choices of all classes, in thousandths: ``resource R`` is what is left of one, ``class K`` what is produced of one
beyond what is asked of it, both 0 or more where a selection is possible; ``criterion N`` is to be as great as can be,
the first of them first. This imports nothing of the program: the solver has its own way to state a problem.
"""

from collections import Counter
from typing import Any, Final

MOST_CHOICES: Final = 4096
"""Of a class."""
PIECE: Final = 30
"""Strategies in one piece of the last criterion, table order."""
SETTLED: Final = 5
"""Criteria before table order: Ω, utility to the intense, strategies that are new, thrift, strategies."""

Choice = tuple[frozenset[str], Counter[str]]
"""(facts: names of the strategies, and ``fulfilled K``; amounts by row)"""


class Refused(ValueError):
    """The certificate does not prove its selection; the message says why."""


def criteria(problem: Any) -> list[str]:
    """The rows to be as great as can be, in order."""
    return [f"criterion {number}" for number in range(SETTLED - (-len(problem["strategies"]) // PIECE))]


def list_choices(problem: Any, secure: list[str]) -> list[list[Choice]]:
    """By class, its choices; those of a class in ``secure`` fulfil it. Raises Refused where there are too many."""
    table, desires, groups = problem["strategies"], problem["desires"], []
    barred = {cls for cls, desire in desires.items() if not desire["utility"]}
    for cls in dict.fromkeys([*(s["class"] for s in table.values()), *desires]):
        wanted, i = (desires[cls][key] if cls in desires else 0 for key in ("utility", "intensity"))
        sets: list[list[tuple[int, str, Any]]] = [[]]
        for n, (name, s) in enumerate(table.items()):
            if s["class"] == cls and not barred & {cls, *(c for c, need in s["requires"].items() if need)}:
                sets += [[*o, (n, name, s)] for o in sets if not any({*m["filters"]} & {*s["filters"]} for *_, m in o)]
                if len(sets) > MOST_CHOICES:
                    raise Refused(f"class {cls} has more than {MOST_CHOICES} choices")
        groups.append(list[Choice]())
        for o, made in ((o, sum(s["utility"] for *_, s in o)) for o in sets):
            for f in range(cls in secure, 1 + (0 < wanted <= made)):
                rows = Counter({f"class {cls}": made - f * wanted, "criterion 1": f * i * made, "criterion 4": -len(o)})
                for n, name, s in o:
                    rows.subtract({f"resource {key}": cost for key, cost in s["costs"].items()})
                    rows.subtract({f"class {key}": need for key, need in s["requires"].items()})
                    rows["criterion 2"] -= name not in problem["previous"]
                    rows[f"criterion {SETTLED + n // PIECE}"] += 1 << (PIECE - 1 - n % PIECE)
                rows["criterion 3"] = rows[f"resource {problem['thrift']}"]
                rows["criterion 0"] = f * (problem["intensity"] * i + problem["utility"] * made)
                rows["criterion 0"] += problem["spare"] * rows[f"resource {problem['spare_of']}"]
                groups[-1].append((frozenset([name for _, name, _ in o] + [f"fulfilled {cls}"] * f), rows))
    return groups
