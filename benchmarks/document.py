"""The rows of a full run as a page: ``docs/benchmarks.md``."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path

from benchmarks.report import Row, figure, machine, versions

HEAD = """\
# Benchmarks

The last full run of `hbba bench --markdown docs/benchmarks.md` ({date}). Ours and the peer's run in turn, in the same
run on the same machine; *ours* and *peer* are medians, *ours/peer* is the median over the rounds where both ran, and
*spread* is the interquartile range of ours over its median. Absolute figures are those of this machine and its other
work: trust the ratios. Of throughput and of *times real time* more is better, of times and CPU less.

- Machine: {machine}
- Versions: {versions}

One of them alone: `hbba bench NAME`, rough figures in seconds: `--quick`, for machines: `--json`, or `--out FILE`.
"""


def document(rows: Sequence[Row]) -> str:
    """The whole page."""
    named = ", ".join(f"{name} {version}" for name, version in versions().items())
    parts = [HEAD.format(date=f"{datetime.now(UTC):%Y-%m-%d}", machine=machine(), versions=named)]
    for name, group in groupby(rows, key=lambda r: r.benchmark):
        parts.append(f"\n## {name}\n\n{_about(name)}\n\n{_table(list(group))}")
    return "".join(parts)


def _about(name: str) -> str:
    """What the benchmark's file says of itself."""
    path = Path(__file__).parent / f"{name}.py"
    if not path.is_file():
        return ""
    return (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").replace("``", "`")


def _table(rows: Sequence[Row]) -> str:
    lines = [
        "| case | metric | unit | ours | peer | peer is | ours/peer | spread | n |",
        "|---|---|---|--:|--:|---|--:|--:|--:|",
    ]
    for r in rows:
        ratio = "" if r.ratio is None else f"{r.ratio:.2f}"
        cells = (
            r.case, r.metric, r.unit, figure(r.ours), figure(r.peer), r.peer_name, ratio, f"{100 * r.spread:.0f} %",
            str(r.n),
        )  # fmt: skip
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"
