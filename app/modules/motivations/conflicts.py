"""Conflicts of behaviors at the arbiters, and for how long they last. Pure.

Two behaviors are in conflict while both command one actuator group and the arbiter lets only one of them through, each
for desires of other classes. EMIB's Distress deactivates one of two behaviors that have been exploited together for
too long (Michaud 2002; thesis 2.1.2); here the arbiter never lets both through, so that the one that is outdone,
without any effect, is the one to deactivate.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

from app.messages import Exploitation, IntentionReport

GAP_S: Final = 1.0
"""A conflict that is interrupted for less (s) goes on: arbiters report ten times a second."""


@dataclass(frozen=True, slots=True)
class Conflict:
    """``outdone`` commands ``group`` in vain, for ``winner`` is let through."""

    group: str
    winner: str
    outdone: str


@dataclass(slots=True)
class _Span:
    begin: float
    last: float


class ConflictLog:
    """The conflicts under way. Times are of the robot's clock (s)."""

    def __init__(self) -> None:
        self._spans: dict[Conflict, _Span] = {}
        #: When each behavior was last let through, by group.
        self._through: dict[tuple[str, str], float] = {}

    def take(self, report: Exploitation) -> None:
        """An arbiter reports."""
        if report.behavior is None:
            return
        now = report.stamp
        self._through[report.group, report.behavior] = now
        for outdone in report.outdone:
            span = self._spans.setdefault(Conflict(report.group, report.behavior, outdone), _Span(now, now))
            if now - span.last > GAP_S:
                span.begin = now
            span.last = now

    def lasting(self, now: float) -> dict[Conflict, float]:
        """The conflicts under way at ``now``, and for how long (s) each has been."""
        self._spans = {conflict: span for conflict, span in self._spans.items() if now - span.last <= GAP_S}
        return {conflict: now - span.begin for conflict, span in self._spans.items()}

    def moves(self, behavior: str, group: str, now: float) -> bool:
        """Whether ``behavior`` is let through to ``group`` at ``now``."""
        return now - self._through.get((group, behavior), -math.inf) <= GAP_S


def classes_served(behavior: str, intention: IntentionReport) -> frozenset[str]:
    """The desire classes of the strategies at work that open a filter of ``behavior``."""
    return frozenset(
        strategy.cls
        for strategy in intention.strategies
        for name, divisor in strategy.filters.items()
        if divisor != math.inf and name.partition(".")[0] == behavior
    )


def in_vain(
    lasting: Mapping[Conflict, float], after_s: float, intention: IntentionReport, exploited: Collection[str]
) -> dict[str, Conflict]:
    """The classes that have been served in vain for ``after_s`` (s), and the conflict that is why.

    ``exploited`` are the classes that are exploited: a behavior that moves something else is not in vain. A winner
    without a class, as one that people move by hand without any desire, is no rival.
    """
    found: dict[str, Conflict] = {}
    for conflict, lasted_s in lasting.items():
        winners = classes_served(conflict.winner, intention)
        classes = classes_served(conflict.outdone, intention) - winners
        if lasted_s >= after_s and winners:
            found.update((cls, conflict) for cls in sorted(classes) if cls not in exploited and cls not in found)
    return found
