"""Table and picture of the closed-loop experiment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.experiments.closed_loop.result import RunResult, back_s, judge, period_p99_ms

#: CPU of other programs (% of one core) above which the figures say little.
OTHERS = 25.0


def table(results: Sequence[RunResult]) -> str:
    """A row for each phase, the open loop beside the closed one."""
    lines = [
        "| | open: in budget after, s | CPU over budget | φ changed | closed: after, s | CPU over budget | φ changed |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    for opened, closed in pairs(results):
        for phase in opened.phases:
            cells = [judge(result, phase) for result in (opened, closed)]
            judged = " | ".join(f"{_s(j.settled_s)} | {j.over:.2f} | {j.left}" for j in cells)
            lines.append(f"| {phase.name} | {judged} |")
    lines += [
        "",
        "| run | loop | φ back after relief, s | planner's period p99, ms | modules restarted | world's rate |",
    ]
    lines.append("|---|---|--:|--:|--:|--:|")
    for result in results:
        back = "–"
        if len(result.phases) > 2:
            back = _s(back_s(result, result.phases[1], result.phases[-1].begins))
        figures = f"{back} | {_ms(period_p99_ms(result))} | {result.restarts} | {result.world_rate:.2f}"
        lines.append(f"| {result.kind} | {_loop(result)} | {figures} |")
    return "\n".join(lines)


def pairs(results: Sequence[RunResult]) -> list[tuple[RunResult, RunResult]]:
    """The open and the closed run of each kind."""
    by_kind: dict[str, dict[bool, RunResult]] = {}
    for result in results:
        by_kind.setdefault(result.kind, {})[result.closed] = result
    return [(both[False], both[True]) for both in by_kind.values() if len(both) == 2]


def doubts(results: Sequence[RunResult]) -> list[str]:
    """Reasons why the figures say little, as sentences; empty if they are good."""
    said = []
    for result in results:
        what = f"{result.kind}, loop {_loop(result)}"
        # The competitor of a phase is one of the others.
        mine = 50.0 * sum(p.name == "half taken" for p in result.phases) / len(result.phases)
        if result.others - mine > OTHERS:
            said.append(f"other programs took {result.others - mine:.0f} % of a core meanwhile ({what})")
        if result.world_rate < 0.9:
            said.append(f"the world ran at {result.world_rate:.2f} of real time ({what})")
    return said


def plot(results: Sequence[RunResult], path: Path) -> None:
    """Used CPU and its budget over time, open and closed. Raises OSError if the file cannot be written."""
    figure = Figure(figsize=(11, 3.2 * len(pairs(results))), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(pairs(results)), 2, squeeze=False, sharey="row")
    for row, both in zip(axes, pairs(results), strict=True):
        for axis, result in zip(row, both, strict=True):
            times = [s.t for s in result.samples]
            axis.plot(times, [s.used for s in result.samples], color="#1b4965", label="measured")
            axis.plot(times, [s.budget for s in result.samples], color="#ca6702", label="budget")
            for phase in result.phases:
                axis.axvline(phase.begins, color="#999999", lw=0.8)
                axis.text(phase.begins, axis.get_ylim()[1], f" {phase.name}", va="top", fontsize=8)
            axis.set_title(f"{result.kind}, loop {_loop(result)}", loc="left", fontsize=11)
            axis.set_xlabel("s")
            axis.set_ylabel("% of a core")
            axis.grid(alpha=0.25)
            axis.legend(loc="lower right", fontsize=8)
    figure.savefig(path, dpi=130)


def _loop(result: RunResult) -> str:
    return "closed" if result.closed else "open"


def _s(seconds: float) -> str:
    return f"{seconds:.1f}" if math.isfinite(seconds) else "never"


def _ms(milliseconds: float) -> str:
    return "–" if math.isnan(milliseconds) else f"{milliseconds:.0f}"
