"""What the lanes were, out of what a recording tells of its attention: desires, intentions, divisors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from app.console.live.lanes import WINDOW_S, LaneSampler
from app.messages import DesireRecord, DesiresRecord, Divisors, IntentionRecord, ReasonRecord

#: Whether a channel said anything between two times (s).
Spoke = Callable[[str, float, float], bool]


def recorded_lanes(
    lanes: LaneSampler,
    records: Iterable[Any],
    begin: float,
    end: float,
    period_s: float,
    spoke: Spoke = lambda channel, begin, end: True,
) -> Iterator[tuple[float, list[dict[str, Any]]]]:
    """``(stamp, rows)`` every ``period_s`` from ``begin`` to before ``end`` (s), from the first record on.

    ``records`` in the order of their stamps; those before ``begin`` say what stood there. What was offered to the
    filters is not recorded: what each let through is 1/φ, and nothing was offered where its channel did not speak.
    """
    strongest: dict[str, DesireRecord] = {}
    reasons: dict[str, ReasonRecord] = {}
    selected: tuple[str, ...] = ()
    divisors = dict.fromkeys(lanes.filters, math.inf)
    channels = {name: lanes.channel(name) for name in lanes.filters}
    waiting, known = list(records), False
    for number in range(max(0, math.ceil((end - begin) / period_s))):
        stamp = begin + number * period_s
        while waiting and waiting[0].stamp <= stamp:
            record, known = waiting.pop(0), True
            match record:
                case DesiresRecord():
                    strongest = _strongest(record.desires)
                case IntentionRecord():
                    selected = record.strategies
                    reasons = {reason.cls: reason for reason in record.reasons}
                case Divisors():
                    divisors |= dict(zip(record.filters, record.divisors, strict=True))
        if known:
            ratios = {
                name: 1.0 / divisor
                if (on := channels.get(name)) is None or spoke(on, stamp - WINDOW_S, stamp)
                else None
                for name, divisor in divisors.items()
            }
            yield stamp, lanes.rows(strongest, selected, reasons, divisors, ratios)


def _strongest(desires: Iterable[DesireRecord]) -> dict[str, DesireRecord]:
    """By class, as the Intention Workspace chooses: the most intense, security before others, then the newest."""
    rising = sorted(desires, key=lambda d: (d.intensity, d.security, d.created))
    return {desire.cls: desire for desire in rising}
