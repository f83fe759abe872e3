"""Why each desire gets what it gets, and what would serve it better.

Every alternative is checked: the problem is solved again with more of one resource, or without one other desire
(:mod:`app.attention.variants`), and the alternative is given only if the optimum then serves the class as promised.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from app.attention.desires import GRAIN, Desire
from app.attention.problem import Selection, SelectionProblem
from app.attention.strategies import Resource
from app.attention.utility_bound import best_utility
from app.attention.variants import Variants
from app.messages import Alternative, Reason


def explain(
    problem: SelectionProblem,
    selection: Selection,
    *,
    time_limit_s: float = 0.1,
    resources: Mapping[str, Resource] | None = None,
    give_up: Callable[[], bool] = lambda: False,
) -> dict[str, Reason]:
    """A reason for each desired class, in the problem's order.

    Alternatives are searched for the unfulfilled classes first, then by falling intensity, until the time is over (0:
    none are searched); a reason without a complete search has ``searched`` False, and an amount that is enough but may
    not be the least is "at most" that in the text. ``resources`` gives the units of the texts. ``give_up`` is called
    before each step; True ends the search. Call it beside the event loop. Raises InvalidProblem.
    """
    deadline = time.perf_counter() + time_limit_s
    problem = problem.with_table()
    facts = _Facts.of(problem, selection)
    variants = Variants(problem, selection, resources or {}, deadline, give_up) if time_limit_s > 0 else None
    order = sorted(problem.desires.values(), key=lambda d: (d.cls in facts.fulfilled, -d.intensity))
    reasons = {desire.cls: _reason(facts, desire, variants) for desire in order}
    return {cls: reasons[cls] for cls in problem.desires}


@dataclass(frozen=True, slots=True)
class _Facts:
    """Facts for the reasons: by class ``got``, the utility produced for it, and ``by``, the strategies that produce
    it."""

    problem: SelectionProblem
    selection: Selection
    fulfilled: frozenset[str]
    inhibited: frozenset[str]
    got: Mapping[str, float]
    by: Mapping[str, list[str]]

    @classmethod
    def of(cls, problem: SelectionProblem, selection: Selection) -> _Facts:
        names = frozenset(selection.strategies)
        got: dict[str, int] = {}
        by: dict[str, list[str]] = {}
        for s, utility in zip(problem.strategies, problem.table.utility, strict=True):
            if s.name in names:
                got[s.cls] = got.get(s.cls, 0) + utility
                by.setdefault(s.cls, []).append(s.name)
        return cls(
            problem,
            selection,
            frozenset(selection.fulfilled),
            frozenset(c for c, desire in problem.desires.items() if desire.utility == 0),
            {c: utility / GRAIN for c, utility in got.items()},
            by,
        )


def _reason(facts: _Facts, desire: Desire, variants: Variants | None) -> Reason:
    cls, wanted = desire.cls, desire.utility
    if wanted == 0:
        text = f"inhibited by a desire of intensity {desire.intensity:g}"
        return Reason("inhibited", 0.0, 0.0, 0.0, text)
    got = facts.got.get(cls, 0.0) if cls in facts.fulfilled else 0.0
    best = max(got, best_utility(facts.problem.table, cls, facts.inhibited))
    by = ", ".join(facts.by.get(cls, ()))
    if got and got >= best:
        return Reason("fulfilled", got, wanted, best, f"fulfilled at its best ({got:g}) by {by}")
    why = "" if got else _obstacle(facts, desire, best)
    alternatives, searched = _alternatives(facts, desire, got=got, best=best, why=why, variants=variants)
    bounds = variants.bounds if variants is not None else frozenset()
    offer = " or ".join(_words(alternative, (cls, alternative.resource) in bounds) for alternative in alternatives)
    if got:
        text = f"fulfilled at {got:g} of {best:g} by {by}"
        if offer:
            text += f"; would get {alternatives[0].utility:g} {offer}"
        return Reason(
            "degraded", got, wanted=wanted, best=best, text=text, alternatives=alternatives, searched=searched
        )
    text = f"unfulfilled: {why}" if why else "unfulfilled: what it needs does not fit beside what is worth more"
    if cls in facts.selection.relaxed:
        text += ", though its security is asked for"
    if offer:
        text += f"; would be fulfilled {offer}"
    return Reason("unfulfilled", 0.0, wanted=wanted, best=best, text=text, alternatives=alternatives, searched=searched)


def _alternatives(
    facts: _Facts, desire: Desire, got: float, best: float, why: str, variants: Variants | None
) -> tuple[tuple[Alternative, ...], bool]:
    """Changes that would serve the desire better, and whether the search for them was complete."""
    cls, wanted = desire.cls, desire.utility
    # If no amount of a resource helps, another desire may still prevent it.
    if why and not _inhibitors(facts, cls):
        return (), True
    if variants is None:
        return (), False
    variants.missing = False
    if why:
        found = variants.without(cls, wanted)
    else:
        found = variants.alternatives(cls, at_least=best if got else wanted)
        if not found and got:
            found = variants.alternatives(cls, at_least=got + 1 / GRAIN)
    return found, not variants.missing


def _obstacle(facts: _Facts, desire: Desire, best: float) -> str:
    """Why no amount of resources could fulfil the desire; "" if some could."""
    table = facts.problem.table
    members = table.members.get(desire.cls)
    if members is None:
        return "no strategy serves this class"
    inhibitors = _inhibitors(facts, desire.cls)
    if best < desire.utility and inhibitors:
        return f"it depends on {' and '.join(inhibitors)}, which is inhibited"
    if best < desire.utility:
        return f"it asks for utility {desire.utility:g}, its strategies produce at most {best:g}"
    missing = [
        {c for c in facts.problem.strategies[index].requires if c not in table.members}
        for index in members.all
        if facts.problem.strategies[index].utility >= desire.utility
    ]
    if missing and all(missing):
        return f"it depends on {' and '.join(sorted(set.union(*missing)))}, which no strategy serves"
    return ""


def _inhibitors(facts: _Facts, cls: str) -> list[str]:
    """The inhibited classes that strategies of ``cls`` require."""
    if not facts.inhibited:
        return []
    table = facts.problem.table
    members = table.members.get(cls)
    required = {c for index in members.all for c in table.requires[index]} if members is not None else set()
    return sorted(required & facts.inhibited)


def _words(alternative: Alternative, bound: bool) -> str:
    """``with 18 % more cpu``; ``with at most 62 % more cpu`` if it is a ``bound``; ``without LocateVoices``."""
    if alternative.kind == "without":
        return f"without {alternative.without}"
    unit = alternative.unit.partition(" of ")[0]
    amount = f"{alternative.amount:g} {unit}".strip()
    return f"with {'at most ' if bound else ''}{amount} more {alternative.resource}"
