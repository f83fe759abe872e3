"""Table and picture of the body experiment."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.experiments.body.experiment import Result
from app.experiments.body.measurement import BASE, Observation, behavior_spans, mode_spans, positions

_MODES = {
    "moving": "#2a9d8f",
    "driving": "#2a9d8f",
    "holding": "#e9c46a",
    "yielding": "#e9c46a",
    "idle": "#d9dde2",
    "stale_command": "#ca6702",
    "refused": "#9b2226",
    "e_stopped": "#9b2226",
    "sensor_failure": "#9b2226",
}
_BEHAVIOR, _TEXT = "#1b4965", "white"


def table(result: Result) -> str:
    """One row for each group."""
    lines = [
        "| group | commanded by (s) | guard (s) | oldest command | speed of its limit | beyond limits | stop to rest |",
        "|---|---|---|---|---|---|---|",
    ]
    for each in result.figures:
        cells = (
            each.group,
            _seconds(each.behaviors),
            _seconds(each.modes),
            "–" if each.oldest_s is None else f"{1e3 * each.oldest_s:.0f} ms",
            f"{100 * each.speed:.0f} %",
            "no" if each.beyond < 1e-3 else f"{each.beyond:.4f}",
            "–" if each.rest_s is None else f"{each.rest_s:.2f} s",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def plot(result: Result, path: Path) -> None:
    """Draw desires, commanding behaviors, states of the guard, and motion. Raises OSError if it cannot be written."""
    groups = [BASE, *result.body.groups]
    moved = [group for group in result.body.groups.values() if _moved(result.seen, group.name)]
    classes = list(dict.fromkeys(cue.cls for cue in result.play.cues))
    heights = [0.28 * len(classes) + 0.4, 0.5 * len(groups) + 0.4, 1.6, *(1.4 for _ in moved)]
    figure = Figure(figsize=(11, sum(heights) + 1.2), layout="constrained")
    FigureCanvasAgg(figure)
    rows = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    _desires(rows[0], result, classes)
    _guards(rows[1], result, groups)
    _base(rows[2], result.seen)
    for axes, group in zip(rows[3:], moved, strict=True):
        for joint in group.joints:
            times, values = positions(result.seen, joint.name)
            axes.plot(times, np.degrees(values), lw=1.2, label=joint.name.removesuffix("_joint").replace("_", " "))
        _title(axes, f"{group.name}: positions (°)")
        axes.legend(fontsize=7, ncols=3, loc="upper left")
    for axes in rows:
        if result.seen.stopped_at is not None:
            axes.axvline(result.seen.stopped_at, color="#9b2226", lw=1)
        axes.grid(alpha=0.25, axis="x")
    rows[-1].set_xlabel("s")
    rows[-1].set_xlim(0, result.play.seconds)
    figure.suptitle("Every actuator group under attention; the emergency stop is the red line")
    figure.savefig(path, dpi=130)


def _desires(axes: Axes, result: Result, classes: list[str]) -> None:
    for cue in result.play.cues:
        until = cue.until if cue.until is not None else result.play.seconds
        axes.barh(classes.index(cue.cls), until - cue.at, left=cue.at, height=0.6, color=_BEHAVIOR, edgecolor="white")
    axes.set_yticks(range(len(classes)), classes, fontsize=8)
    axes.invert_yaxis()
    _title(axes, "Desires")


def _guards(axes: Axes, result: Result, groups: list[str]) -> None:
    for row, group in enumerate(groups):
        for start, end, mode in mode_spans(result.seen, group):
            axes.barh(row + 0.2, end - start, left=start, height=0.36, color=_MODES.get(mode, "#9b2226"))
        for start, end, behavior in behavior_spans(result.seen, group):
            axes.barh(row - 0.2, end - start, left=start, height=0.36, color=_BEHAVIOR)
            if end - start > 0.06 * result.play.seconds:
                axes.text(start + 0.1, row - 0.2, behavior, va="center", fontsize=7, color=_TEXT)
    axes.set_yticks(range(len(groups)), [name.replace("_", " ") for name in groups], fontsize=8)
    axes.invert_yaxis()
    _title(axes, "Behavior that commands (blue), and the guard: acts (green), holds or yields (yellow), stopped (red)")


def _base(axes: Axes, seen: Observation) -> None:
    series = np.array(seen.odometry, dtype=np.float64).reshape(-1, 3)
    axes.plot(series[:, 0], series[:, 1], color=_BEHAVIOR, lw=1.2, label="m/s")
    axes.plot(series[:, 0], series[:, 2], color="#ca6702", lw=1.0, label="rad/s")
    axes.legend(fontsize=7, loc="upper left")
    _title(axes, "base: speed")


def _title(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=9)


def _moved(seen: Observation, group: str) -> bool:
    return any(mode == "moving" for _, _, mode in mode_spans(seen, group))


def _seconds(lengths: Mapping[str, float]) -> str:
    parts = [f"{name} {length:.1f}" for name, length in lengths.items() if length >= 0.05]
    return ", ".join(parts) or "–"
