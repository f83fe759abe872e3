"""Tables and picture of the pursuit study."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.base.errors import ConfigError
from app.experiments.pursuit.result import SCRIPTED, PursuitResult, PursuitSummary, summaries

#: Columns of the table of runs.
COLUMNS = (
    "operator", "task", "mode", "delay_ms", "jitter_ms", "prediction", "seed", "course", "ended", "time_s", "driven_m",
    "speed_mps", "contacts", "monitor_stops", "limited", "distance_m", "distance_p95_m", "visible", "late_share",
    "late",
)  # fmt: skip
_FOLLOW = ("runs, to the end", "contacts", "stops by the monitor", "distance, m: mean, worst p95", "in the picture",
           "way, m", "speed, m/s")  # fmt: skip
_COURSE = ("runs, to the end", "contacts", "stops by the monitor", "time, s", "speed, m/s",
           "speed, of that without delay", "speed allowed")  # fmt: skip
#: By mode and prediction.
_LINES = {
    (1, False): ("Mode 1, measured", "#ca6702", "o--"),
    (1, True): ("Mode 1, predicted", "#ca6702", "o-"),
    (2, False): ("Mode 2, measured", "#1b4965", "s--"),
    (2, True): ("Mode 2, predicted", "#1b4965", "s-"),
}


def tables(results: Sequence[PursuitResult]) -> str:
    """Both tasks, as far as there are results."""
    found = summaries(results)
    follow = [each for each in found if each.condition.task == "follow"]
    course = [each for each in found if each.condition.task == "course"]
    parts = []
    if follow:
        parts.append(_table(_FOLLOW, [(_name(each), _follow_cells(each)) for each in follow], "a person is followed"))
    if course:
        parts.append(_table(_COURSE, [(_name(each), _course_cells(each)) for each in course], "a course is driven"))
    return "\n\n".join(parts)


def _table(columns: Sequence[str], rows: Iterable[tuple[str, Sequence[str]]], title: str) -> str:
    lines = [f"| {' | '.join((title, *columns))} |", "|---" * (len(columns) + 1) + "|"]
    return "\n".join([*lines, *(f"| {' | '.join((name, *cells))} |" for name, cells in rows)])


def _name(each: PursuitSummary) -> str:
    who = "" if each.operator == SCRIPTED else f"{each.operator}: "
    mode = f"Mode {each.condition.mode}, " if each.condition.task == "follow" else ""
    return f"{who}{mode}{each.condition.words}"


def _follow_cells(each: PursuitSummary) -> tuple[str, ...]:
    return (
        f"{each.runs}, {each.ended}",
        str(each.contacts),
        str(each.monitor_stops),
        f"{_figure(each.distance_m)}, {_figure(each.distance_p95_m)}",
        _percent(each.visible),
        f"{each.driven_m:.1f}",
        f"{each.speed_mps:.3f}",
    )


def _course_cells(each: PursuitSummary) -> tuple[str, ...]:
    return (
        f"{each.runs}, {each.ended}",
        str(each.contacts),
        str(each.monitor_stops),
        f"{each.time_s:.1f}",
        f"{each.speed_mps:.3f}",
        _percent(each.speed_share),
        _percent(each.late_share),
    )


def table_csv(results: Iterable[PursuitResult]) -> str:
    """The table of runs (RFC 4180)."""
    text = io.StringIO()
    rows = ([_cell(each, column) for column in COLUMNS] for each in results)
    csv.writer(text, lineterminator="\r\n").writerows([COLUMNS, *rows])
    return text.getvalue()


def _cell(result: PursuitResult, column: str) -> object:
    value = getattr(result.condition if hasattr(result.condition, column) else result, column)
    return round(value, 4) if isinstance(value, float) else value


def plot(results: Sequence[PursuitResult], path: Path) -> None:
    """Draw the scripted operator's measures against the round trip. Raises ConfigError where it cannot be written."""
    found = [each for each in summaries(results) if each.operator == SCRIPTED]
    figure = Figure(figsize=(10, 6.4), layout="constrained")
    FigureCanvasAgg(figure)
    (distance, visible), (farthest, speed) = figure.subplots(2, 2)
    follow = [each for each in found if each.condition.task == "follow"]
    course = [each for each in found if each.condition.task == "course"]
    _curves(distance, follow, [each.distance_m for each in follow], "distance to the person, mean (m)")
    _curves(visible, follow, [_hundred(each.visible) for each in follow], "person in the picture (% of the time)")
    _curves(
        farthest, follow, [each.distance_p95_m for each in follow], "the same, 95th percentile of the worst run (m)"
    )
    _curves(speed, course, [each.speed_mps for each in course], "a course: mean speed (m/s)")
    handles, labels = distance.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper center", ncols=4, frameon=False)
    for axes in (farthest, speed):
        axes.set_xlabel("round trip (ms)")
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as failure:
        raise ConfigError(f"cannot be written: {failure}", str(path)) from None


def _curves(axes: Axes, found: Sequence[PursuitSummary], values: Sequence[float | None], title: str) -> None:
    for (mode, prediction), (label, color, style) in _LINES.items():
        points = sorted(
            (each.condition.delay_ms, value)
            for each, value in zip(found, values, strict=True)
            if value is not None and (each.condition.mode, each.condition.prediction) == (mode, prediction)
        )
        if points:
            axes.plot(*zip(*points, strict=True), style, color=color, label=label, lw=1.8, ms=6)
    axes.set_ylim(0.0, 1.12 * max((value for value in values if value is not None), default=1.0))
    axes.set_title(title, loc="left", fontsize=10)
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)


def _hundred(share: float | None) -> float | None:
    return None if share is None else 100 * share


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.0f} %"


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"
