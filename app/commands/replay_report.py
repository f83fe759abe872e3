"""The report of a replay, as tables for people."""

from __future__ import annotations

import math

from rich.console import Console
from rich.table import Table

from app.logs.replay.report import ReplaySummary


def print_report(report: ReplaySummary, console: Console | None = None) -> None:
    """Print notes, channels, modules, intentions and how fast it went."""
    console = console or Console()
    if not console.is_terminal:
        console.width = max(console.width, 120)
    for note in report.notes:
        console.print(note, highlight=False, markup=False)
    for table in (_channels(report), _modules(report), _intentions(report)):
        console.print(table)
    took = f"{report.log_s:.1f} s of {report.file.name} in {report.wall_s:.1f} s"
    console.print(f"{took}: {report.times_real_time:.1f} times real time", highlight=False, markup=False)
    if report.recorded:
        console.print(f"recorded as {report.recorded}", highlight=False, markup=False)


def _channels(report: ReplaySummary) -> Table:
    table = Table("Channel", title="What the modules said", title_justify="left")
    table.add_column("Messages", justify="right")
    table.add_column("Digest")
    for name, channel in report.channels.items():
        table.add_row(name, f"{channel.messages:,}", channel.digest if channel.messages else "")
    return table


def _modules(report: ReplaySummary) -> Table:
    table = Table("Module", title="What the modules cost", title_justify="left")
    table.add_column("CPU s", justify="right")
    table.add_column("Taken", overflow="fold")
    table.add_column("Said", overflow="fold")
    for name, module in report.modules.items():
        taken = ", ".join(f"{port} {count.taken:,}" for port, count in module.inputs.items())
        said = ", ".join(f"{port} {count:,}" for port, count in module.outputs.items())
        table.add_row(name, f"{module.cpu_s:.3f}", taken, said)
    return table


def _intentions(report: ReplaySummary) -> Table:
    table = Table("At s", title="What was intended", title_justify="left")
    table.add_column("Ω", justify="right")
    table.add_column("Strategies", overflow="fold")
    table.add_column("Fulfilled", overflow="fold")
    table.add_column("φ", overflow="fold")
    for line in report.intentions:
        phi = ", ".join(f"{name} {divisor:g}" for name, divisor in line.divisors.items() if not math.isinf(divisor))
        table.add_row(
            f"{line.stamp - report.begin:.3f}",
            f"{line.omega:g}",
            ", ".join(line.strategies),
            ", ".join(line.fulfilled),
            phi,
        )
    return table
