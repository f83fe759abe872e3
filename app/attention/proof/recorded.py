"""Proven selections in recordings: each is certified from the problem that was recorded, and checked."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from app.attention.proof.certificate import certify
from app.attention.proof.checker import check
from app.attention.proof.equations import Refused
from app.attention.proof.prover import NotBest, NotProven
from app.attention.proof.statement import Claim, state, whole
from app.messages import IntentionReport


@dataclass(frozen=True, slots=True)
class Verdict:
    """On the proven selection that was put in force at ``stamp`` (robot's clock, s).

    ``state``: ``checked``, ``wrong`` (it is not the best) or ``open`` (not known: no proof of a size, in time);
    ``why`` in words, "" where it is checked.
    """

    stamp: float
    state: str
    why: str = ""


def verdicts(table: bytes, reports: Iterable[IntentionReport], time_limit_s: float) -> Iterator[Verdict]:
    """On each proven selection of ``reports``, once each, with ``time_limit_s`` for a proof. ``table`` is what
    ``statement.table_data`` made."""
    stated = json.loads(table)
    last: float | None = None
    known: dict[str, Verdict] = {}
    for report in reports:
        # An intention is published again once its reasons are complete.
        if not report.proven or report.stamp == last:
            continue
        last = report.stamp
        if report.desires.keys() != report.asked.keys():
            yield Verdict(report.stamp, "open", "an older program recorded it, without what was asked of it")
            continue
        claim = claim_in(stated, report)
        key = json.dumps([claim.problem["desires"], claim.problem["capacities"], claim.problem["previous"]])
        key += json.dumps([[each.name, each.utility, dict(each.costs)] for each in report.changed])
        key += json.dumps([report.omega, claim.selected, claim.fulfilled, claim.relaxed])
        if key not in known:
            known[key] = _verdict(claim, report, time_limit_s)
        yield Verdict(report.stamp, known[key].state, known[key].why)


def claim_in(table: Mapping[str, Any], report: IntentionReport) -> Claim:
    """What ``report`` claims of the problem it answers, over ``table``."""
    capacities = {name: use.capacity for name, use in report.use.items()}
    problem = state(_table_of(table, report), report.asked, capacities, report.previous)
    return Claim(problem, tuple(s.name for s in report.strategies), report.fulfilled, report.relaxed)


def _table_of(table: Mapping[str, Any], report: IntentionReport) -> Mapping[str, Any]:
    """``table`` with the costs and utilities that ``report`` was made with."""
    strategies = dict(table["strategies"])
    for each in report.changed:
        costs = {resource: whole(cost) for resource, cost in each.costs.items()}
        strategies[each.name] = {**strategies[each.name], "utility": whole(each.utility), "costs": costs}
    return {**table, "strategies": strategies}


def _verdict(claim: Claim, report: IntentionReport, time_limit_s: float) -> Verdict:
    try:
        omega = check(certify(claim, time_limit_s=time_limit_s))
    except NotBest as failure:
        return Verdict(report.stamp, "wrong", str(failure))
    except NotProven as failure:
        return Verdict(report.stamp, "open", str(failure))
    except Refused as failure:
        return Verdict(report.stamp, "wrong", str(failure))
    if omega != round(report.omega * 1e6):
        return Verdict(report.stamp, "wrong", f"its Ω is {omega / 1e6:g}, not {report.omega:g}")
    return Verdict(report.stamp, "checked")
