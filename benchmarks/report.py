"""The one format of a measured figure, for every benchmark: a row, a table for people, a file for machines."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import TextIO


@dataclass(frozen=True, slots=True)
class Row:
    """One figure of ours beside a peer's.

    ``benchmark``, ``case`` and ``metric`` say what was measured, in ``unit``; ``ours`` and ``peer`` are medians (peer
    None: measured alone, or the peer cannot do it); ``ratio`` is ours / peer, the median over the rounds where both
    ran; ``spread`` the interquartile range of ours over its median (0.1: the middle half lies within 10 %); ``n`` how
    many rounds or samples ``ours`` rests on.
    """

    benchmark: str
    case: str
    metric: str
    unit: str
    ours: float
    peer: float | None
    peer_name: str
    ratio: float | None
    spread: float
    n: int


def row(
    benchmark: str,
    case: str,
    metric: str,
    unit: str,
    ours: Sequence[float],
    peer: Sequence[float] | None = None,
    peer_name: str = "",
) -> Row:
    """Make a :class:`Row` of samples. ``ours`` holds at least one; equally many of both are taken as paired rounds."""
    middle = median(ours)
    if len(ours) > 1:
        first, _, third = quantiles(ours, n=4, method="inclusive")
        spread = (third - first) / abs(middle) if middle else 0.0
    else:
        spread = 0.0
    ratio = None
    if peer:
        if len(peer) == len(ours) and all(peer):
            ratio = median(mine / other for mine, other in zip(ours, peer, strict=True))
        elif median(peer):
            ratio = middle / median(peer)
    return Row(
        benchmark, case, metric, unit, middle, median(peer) if peer else None, peer_name, ratio, spread, len(ours)
    )


def machine() -> str:
    """What the figures were taken on, in one line."""
    load = f", load average {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{platform.python_implementation()} {platform.python_version()}, {os.cpu_count()} cores{load}"


def print_table(rows: Sequence[Row], stream: TextIO = sys.stdout) -> None:
    """Print ``rows`` in aligned columns under a line that names the machine."""
    header = ("benchmark", "case", "metric", "unit", "ours", "peer", "peer is", "ours/peer", "spread", "n")
    cells = [
        (
            r.benchmark,
            r.case,
            r.metric,
            r.unit,
            _figure(r.ours),
            _figure(r.peer),
            r.peer_name,
            "" if r.ratio is None else f"{r.ratio:.2f}",
            f"{100 * r.spread:.0f} %",
            str(r.n),
        )
        for r in rows
    ]
    widths = [max(len(line[i]) for line in (header, *cells)) for i in range(len(header))]
    numbers = {4, 5, 7, 8, 9}
    print(machine(), file=stream)
    for line in (header, *cells):
        aligned = (
            c.rjust(w) if i in numbers else c.ljust(w) for i, (c, w) in enumerate(zip(line, widths, strict=True))
        )
        print("  ".join(aligned).rstrip(), file=stream)


def write_json(rows: Sequence[Row], path: Path) -> None:
    """Write ``rows`` and the machine they come from to ``path`` (JSON: ``{machine, rows: [...]}``)."""
    path.write_text(json.dumps({"machine": machine(), "rows": [asdict(r) for r in rows]}, indent=1) + "\n")


def _figure(value: float | None) -> str:
    """Three significant digits, without an exponent."""
    if value is None:
        return ""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}"
