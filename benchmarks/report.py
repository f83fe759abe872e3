"""The one format of a measured figure, for every benchmark: a row, a table for people, a file for machines."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from statistics import median, quantiles
from typing import TextIO

from app.base.paths import processor


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


#: What a figure may depend on: ours, the libraries it rests on, and the peers.
PACKAGES = (
    "hbba", "numpy", "opencv-python-headless", "ortools", "mujoco", "zxing-cpp", "mcap", "rosbags", "zstandard",
    "fastapi", "uvicorn", "viser", "anyio", "ezmsg",
)  # fmt: skip


def machine() -> str:
    """What the figures were taken on, in one line."""
    load = f", load average {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{processor()}, {os.cpu_count()} cores{load}"


def versions() -> dict[str, str]:
    """Versions of Python, of this project (with its commit, where it is a checkout), of its libraries and peers."""
    found = {platform.python_implementation(): platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    commit = subprocess.run(
        ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if commit.returncode == 0:
        found["hbba"] += f" ({commit.stdout.strip()})"
    return found


def benchmark_main(description: str | None, measure: Callable[[bool], Sequence[Row]]) -> int:
    """The command line of one benchmark: measure (roughly if ``--quick``), print the table or ``--json``, write
    ``--out FILE``."""
    parser = argparse.ArgumentParser(description=(description or "").strip().splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="rough figures in a few seconds")
    parser.add_argument("--json", action="store_true", help="print the rows as one JSON document instead")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write that JSON document here")
    args = parser.parse_args()
    rows = measure(args.quick)
    if args.json:
        print(json_text(rows))
    else:
        print_table(rows)
    if args.out:
        write_json(rows, args.out)
    return 0


def print_table(rows: Sequence[Row], stream: TextIO = sys.stdout) -> None:
    """Print ``rows`` in aligned columns under a line that names the machine."""
    header = ("benchmark", "case", "metric", "unit", "ours", "peer", "peer is", "ours/peer", "spread", "n")
    cells = [
        (
            r.benchmark,
            r.case,
            r.metric,
            r.unit,
            figure(r.ours),
            figure(r.peer),
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


def json_text(rows: Sequence[Row]) -> str:
    """``rows`` and what they come from as JSON: ``{machine, versions, rows: [...]}``."""
    content = {"machine": machine(), "versions": versions(), "rows": [asdict(r) for r in rows]}
    return json.dumps(content, indent=1, ensure_ascii=False)


def write_json(rows: Sequence[Row], path: Path) -> None:
    """Write :func:`json_text` to ``path``."""
    path.write_text(json_text(rows) + "\n", encoding="utf-8")


def read_rows(content: Mapping[str, Sequence[Mapping[str, object]]]) -> list[Row]:
    """The rows of what :func:`write_json` wrote."""
    return [Row(**entry) for entry in content["rows"]]  # type: ignore[arg-type]  # as written


def figure(value: float | None) -> str:
    """Three significant digits, without an exponent."""
    if value is None:
        return ""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}"
